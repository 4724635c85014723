#include "client/io/geometry_file.h"

#include <random>

#include "client/io/file_bytes.h"
#include "tests/client/io/expect_error.h"
#include "tests/support/shapes.h"
#include "tests/support/temp_folder.h"

namespace cagefit::client {
namespace {

std::string TempFile(const std::string& name) { return cagefit::testing::TempFolder() + name; }

TEST(GeometryFileTest, NamesTheFileInEveryError) {
  EXPECT_EQ(ReadGeometry("gone.ply").status().code(), absl::StatusCode::kNotFound);
  EXPECT_INVALID(ReadGeometry("scan.e57"), "scan.e57: its name ends with \".e57\"; expected .ply");
  const std::string path = TempFile("not_really.ply");
  ASSERT_TRUE(WriteFileBytes(path, "\x89PNG\r\n\x1a\n").ok());
  EXPECT_INVALID(ReadGeometry(path), path + ": line 1");
  ASSERT_TRUE(WriteFileBytes(path, "").ok());
  EXPECT_INVALID(ReadGeometry(path), path + ": the file is empty");
}

TEST(GeometryFileTest, EndingsAreReadInAnyCase) {
  EXPECT_TRUE(IsGeometryFile("A/B.PLY"));
  EXPECT_FALSE(IsGeometryFile("a.ply/b"));
  EXPECT_FALSE(IsGeometryFile("ply"));
}

TEST(GeometryFileTest, ACloudIsNoControlMesh) {
  const std::string path = TempFile("points.xyz");
  ASSERT_TRUE(WriteFileBytes(path, "1 2 3\n4 5 6\n").ok());
  EXPECT_INVALID(ReadControlMesh(path), "it has no faces");
  const std::string torn = TempFile("torn.obj");
  ASSERT_TRUE(WriteFileBytes(torn, "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 9 9 9\nf 1 2 3\n").ok());
  EXPECT_INVALID(ReadControlMesh(torn), torn);
}

TEST(GeometryFileTest, ToCloudMakesUnitNormalsAndDropsPointsWithoutDirection) {
  Geometry geometry;
  geometry.mesh.vertices = Points3d::Random(3, 3);
  geometry.normals.resize(3, 3);
  geometry.normals << 2, 0, 0, 0, 0, 3, 0, 0, 4;
  const PointCloud cloud = ToCloud(geometry);
  ASSERT_EQ(cloud.size(), 2);
  EXPECT_EQ(cloud.normals.col(0), Eigen::Vector3f(1, 0, 0));
  EXPECT_TRUE(cloud.normals.col(1).isApprox(Eigen::Vector3f(0, 0.6f, 0.8f)));
  geometry.normals.resize(3, 0);
  EXPECT_FALSE(ToCloud(geometry).has_normals());
}

TEST(GeometryFileTest, AMeshWithoutNormalsGetsThem) {
  Geometry geometry;
  geometry.mesh = testing::Icosphere(1);
  const PointCloud cloud = ToCloud(geometry);
  ASSERT_EQ(cloud.normals.cols(), geometry.mesh.vertices.cols());
  EXPECT_GT(cloud.normals.cwiseProduct(cloud.points).colwise().sum().minCoeff(), 0.9f);
}

// Short form of fuzzing: damaged files of every format either load or give an error.
TEST(GeometryFileTest, DamagedFilesNeverBreakTheReaders) {
  const TriangleMesh mesh = testing::Icosphere(1);
  std::mt19937 random(7);
  for (const char* extension : {".obj", ".off", ".ply", ".stl", ".drc"}) {
    const std::string path = TempFile(std::string("damaged") + extension);
    ASSERT_TRUE(WriteMesh(path, mesh).ok());
    const std::string sound = *ReadFileBytes(path, 1 << 20);
    int loaded = 0, refused = 0;
    for (int round = 0; round < 300; ++round) {
      std::string bytes = sound.substr(0, round % 3 == 0 ? random() % sound.size() : sound.size());
      for (uint32_t k = random() % 4; k > 0 && !bytes.empty(); --k) {
        bytes[random() % bytes.size()] = static_cast<char>(random());
      }
      ASSERT_TRUE(WriteFileBytes(path, bytes).ok());
      const auto geometry = ReadGeometry(path);
      (geometry.ok() ? loaded : refused) += 1;
      if (!geometry.ok()) continue;
      EXPECT_TRUE(geometry->mesh.vertices.allFinite());
      EXPECT_GE(geometry->mesh.triangles.size() == 0 ? 0 : geometry->mesh.triangles.minCoeff(), 0);
      EXPECT_LT(geometry->mesh.triangles.size() == 0 ? -1 : geometry->mesh.triangles.maxCoeff(),
                geometry->mesh.vertices.cols());
    }
    EXPECT_GT(refused, 50) << extension;
    EXPECT_GT(loaded, 10) << extension;
  }
}

}  // namespace
}  // namespace cagefit::client
