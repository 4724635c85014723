#include "client/commands/true_motion.h"

#include <gmock/gmock.h>

#include <filesystem>

#include "client/io/geometry_file.h"
#include "tests/support/shapes.h"
#include "tests/support/temp_folder.h"

namespace cagefit::client {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

// A folder of its own with a file for each mesh.
std::string Write(const std::string& name, const std::vector<TriangleMesh>& meshes) {
  const std::string folder = cagefit::testing::TempFolder() + "true_motion_" + name;
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
  for (size_t k = 0; k < meshes.size(); ++k) {
    EXPECT_TRUE(WriteMesh(folder + "/f" + std::to_string(k) + ".ply", meshes[k]).ok());
  }
  return folder;
}

TEST(TrueMotionTest, GivesTheVerticesOfEveryFrame) {
  TriangleMesh moved = testing::Icosphere(1);
  moved.vertices.row(0).array() += 0.5;
  const std::string folder = Write("moved", {testing::Icosphere(1), moved});
  auto motion = TrueMotion::Open({folder}, 2);
  ASSERT_TRUE(motion.ok()) << motion.status();
  EXPECT_TRUE(motion->Check().ok());
  EXPECT_NEAR((*motion->Vertices(1) - *motion->Vertices(0)).row(0).mean(), 0.5, 1e-6);
  auto files = TrueMotion::Open({folder + "/f1.ply", folder + "/f0.ply"}, 2);
  ASSERT_TRUE(files.ok()) << "files stay in the order given";
  EXPECT_NEAR((*files->Vertices(0) - moved.vertices).norm(), 0, 1e-5);
}

TEST(TrueMotionTest, AnotherNumberOfFilesIsNamed) {
  const std::string folder = Write("few", {testing::Icosphere(1)});
  const absl::Status status = TrueMotion::Open({folder}, 3).status();
  EXPECT_TRUE(absl::IsInvalidArgument(status));
  EXPECT_THAT(std::string(status.message()),
              AllOf(HasSubstr(folder + ": 1 frames of the true motion"), HasSubstr(", 3")));
}

TEST(TrueMotionTest, AnotherConnectivityNamesFileAndCounts) {
  const std::string folder = Write("other", {testing::Icosphere(1), testing::Icosphere(2)});
  const absl::Status status = TrueMotion::Open({folder}, 2)->Check();
  EXPECT_THAT(std::string(status.message()),
              AllOf(HasSubstr(folder + "/f1.ply: 162 vertices and 320 triangles"),
                    HasSubstr("f0.ply has 42 and 80")));
  TriangleMesh turned = testing::Icosphere(1);
  turned.triangles.col(3).reverseInPlace();
  const std::string same_size = Write("turned", {testing::Icosphere(1), turned});
  EXPECT_THAT(std::string(TrueMotion::Open({same_size}, 2)->Check().message()),
              HasSubstr("/f1.ply: its 80 triangles are not those of"));
}

}  // namespace
}  // namespace cagefit::client
