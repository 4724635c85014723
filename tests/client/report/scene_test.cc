#include "client/report/scene.h"

#include <gmock/gmock.h>

#include <list>

#include "absl/strings/str_cat.h"
#include "client/io/geometry_file.h"
#include "tests/support/shapes.h"
#include "tests/support/temp_folder.h"

namespace cagefit::client {
namespace {

using ::testing::Each;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::SizeIs;

class SceneTest : public ::testing::Test {
 protected:
  SceneTest() : cage_(Cage()) {}

  static ControlMesh Cage() {
    const TriangleMesh sphere = testing::Icosphere(2);
    return ControlMesh::Create(sphere.vertices, sphere.triangles).value();
  }
  std::string Write(const Points3d& points) {
    PointCloud cloud;
    cloud.points = points.cast<float>();
    const std::string path =
        absl::StrCat(cagefit::testing::TempFolder(), "scene_", files_++, ".ply");
    EXPECT_EQ(WriteCloud(path, cloud), absl::OkStatus());
    return path;
  }
  ReportFrame Frame(size_t number, const std::string& file, double rms = 1) {
    return {number, file, &cage_.vertices(), rms};
  }

  const ControlMesh cage_;
  int files_ = 0;
};

TEST_F(SceneTest, MeasuresBothWays) {
  // The limit surface of the unit icosphere lies inside of it, and far inside of this target.
  const Scene scene = BuildScene(cage_, {Frame(3, Write(testing::Icosphere(4, 1.1).vertices))});
  ASSERT_THAT(scene.frames, SizeIs(1));
  const SceneFrame& frame = scene.frames.front();
  EXPECT_EQ(frame.number, 3u);
  EXPECT_EQ(frame.target_points, 2562);
  EXPECT_EQ(frame.points.cols(), 2562);
  EXPECT_EQ(static_cast<int64_t>(frame.surface_deviations.size()), scene.mesh.position.rows());
  EXPECT_THAT(frame.surface_deviations,
              Each(::testing::AllOf(::testing::Lt(-0.1), ::testing::Gt(-0.2))));
  EXPECT_THAT(frame.point_deviations,
              Each(::testing::AllOf(::testing::Lt(-0.1), ::testing::Gt(-0.2))));
}

TEST_F(SceneTest, AFrameWhoseTargetIsGoneHasNoDeviations) {
  const Scene scene = BuildScene(cage_, {Frame(0, "/nowhere/frame.ply")});
  ASSERT_THAT(scene.frames, SizeIs(1));
  EXPECT_THAT(scene.frames.front().surface_deviations, IsEmpty());
  EXPECT_EQ(scene.frames.front().target_points, 0);
}

TEST_F(SceneTest, LeavesOutWhatLiesFarOff) {
  Points3d target = testing::Icosphere(3).vertices;
  target.col(0) *= 1000;
  const Scene scene = BuildScene(cage_, {Frame(0, Write(target))});
  EXPECT_EQ(scene.frames.front().points.cols(), target.cols() - 1);
  EXPECT_EQ(scene.frames.front().target_points, target.cols());
}

TEST_F(SceneTest, KeepsWithinItsBytesAndKeepsTheWorstFrame) {
  const std::string file = Write(testing::Icosphere(3).vertices);
  std::vector<ReportFrame> frames;
  for (size_t k = 0; k < 40; ++k) frames.push_back(Frame(10 + k, file, k == 17 ? 2 : 1));
  SceneLimits limits;
  limits.surface_vertices = 1000;  // 642 of them
  limits.fewest_points = 100;
  limits.bytes = 6 * (6 * 162 + 642 + 7 * 100);  // six frames
  const Scene scene = BuildScene(cage_, frames, limits);
  std::vector<size_t> numbers;
  for (const SceneFrame& frame : scene.frames) {
    numbers.push_back(frame.number);
    EXPECT_EQ(frame.points.cols(), 100);
  }
  EXPECT_THAT(numbers, ElementsAre(10, 18, 26, 27, 34, 42));
}

}  // namespace
}  // namespace cagefit::client
