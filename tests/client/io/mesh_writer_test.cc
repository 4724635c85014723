#include <gmock/gmock.h>

#include <cmath>
#include <random>

#include "client/io/file_bytes.h"
#include "client/io/geometry_file.h"
#include "tests/support/shapes.h"
#include "tests/support/temp_folder.h"

namespace cagefit::client {
namespace {

std::string TempFile(const std::string& name) { return cagefit::testing::TempFolder() + name; }

TriangleMesh Irregular() {
  TriangleMesh mesh = testing::MixedValences();
  mesh.vertices *= 1.0 / 3;  // not representable in few digits
  return mesh;
}

TEST(MeshWriterTest, DoublesSurviveTextAndPly) {
  const TriangleMesh mesh = Irregular();
  for (const char* name : {"mesh.obj", "mesh.off", "mesh.ply"}) {
    ASSERT_TRUE(WriteMesh(TempFile(name), mesh).ok());
    const auto back = ReadGeometry(TempFile(name));
    ASSERT_TRUE(back.ok()) << back.status();
    EXPECT_EQ(back->mesh.vertices, mesh.vertices) << name;
    EXPECT_EQ(back->mesh.triangles, mesh.triangles) << name;
  }
}

TEST(MeshWriterTest, FloatsSurviveDracoAndStl) {
  const TriangleMesh mesh = Irregular();
  for (const char* name : {"mesh.drc", "mesh.stl"}) {
    ASSERT_TRUE(WriteMesh(TempFile(name), mesh).ok());
    const auto back = ReadGeometry(TempFile(name));
    ASSERT_TRUE(back.ok()) << back.status();
    ASSERT_EQ(back->mesh.triangles.cols(), mesh.triangles.cols()) << name;
    for (int64_t f = 0; f < mesh.triangles.cols(); ++f) {
      for (int c = 0; c < 3; ++c) {
        const Eigen::Vector3f before = mesh.vertices.col(mesh.triangles(c, f)).cast<float>();
        const Eigen::Vector3f after =
            back->mesh.vertices.col(back->mesh.triangles(c, f)).cast<float>();
        EXPECT_EQ(before, after) << name;
      }
    }
  }
}

TEST(MeshWriterTest, NormalsOfCornersAreWrittenAndInPlyTheirMeans) {
  const TriangleMesh mesh = {(Points3d(3, 4) << 0, 1, 1, 0, 0, 0, 1, 1, 0, 0, 0, 1).finished(),
                             (Triangles(3, 2) << 0, 0, 1, 2, 2, 3).finished()};
  const CornerNormals normals = {(Points3d(3, 2) << 0, 1, 0, 0, 1, 0).finished(),
                                 (Triangles(3, 2) << 0, 1, 0, 1, 0, 1).finished()};
  ASSERT_TRUE(WriteMesh(TempFile("normals.obj"), mesh, normals).ok());
  EXPECT_EQ(ReadFileBytes(TempFile("normals.obj"), 1000).value(),
            "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 1\nvn 0 0 1\nvn 1 0 0\n"
            "f 1//1 2//1 3//1\nf 1//2 3//2 4//2\n");
  ASSERT_TRUE(WriteMesh(TempFile("normals.ply"), mesh, normals).ok());
  const auto back = ReadGeometry(TempFile("normals.ply"));
  ASSERT_TRUE(back.ok()) << back.status();
  EXPECT_EQ(back->mesh.vertices, mesh.vertices);
  EXPECT_EQ(back->mesh.triangles, mesh.triangles);
  const float half = std::sqrt(0.5f);
  Points3f expected(3, 4);
  expected << half, 0, half, 1, 0, 0, 0, 0, half, 1, half, 0;
  EXPECT_TRUE(back->normals.isApprox(expected)) << back->normals;
}

TEST(MeshWriterTest, CreasesAndCornersSurviveObj) {
  const TriangleMesh mesh = testing::OpenGrid(3);
  CreaseTags tags;
  tags.edges = {{5, 6}, {6, 10}};
  tags.corners = {0, 3};
  const auto cage = ControlMesh::Create(mesh.vertices, mesh.triangles, tags);
  ASSERT_TRUE(cage.ok()) << cage.status();
  ASSERT_TRUE(WriteControlMesh(TempFile("tags.obj"), *cage).ok());
  const auto back = ReadControlMesh(TempFile("tags.obj"));
  ASSERT_TRUE(back.ok()) << back.status();
  EXPECT_EQ(back->tags().edges, tags.edges);
  EXPECT_EQ(back->tags().corners, tags.corners);
  EXPECT_EQ(WriteControlMesh(TempFile("tags.ply"), *cage).code(),
            absl::StatusCode::kInvalidArgument);
}

TEST(MeshWriterTest, CloudsSurvive) {
  std::mt19937 random(1);
  PointCloud cloud;
  cloud.points = Points3f::NullaryExpr(3, 50, [&] { return random() * 1e-9f; });
  cloud.normals = cloud.points.colwise().normalized();
  for (const char* name : {"cloud.ply", "cloud.xyz"}) {
    ASSERT_TRUE(WriteCloud(TempFile(name), cloud).ok());
    const auto back = ReadGeometry(TempFile(name));
    ASSERT_TRUE(back.ok()) << back.status();
    EXPECT_EQ(back->mesh.vertices.cast<float>(), cloud.points) << name;
    EXPECT_EQ(back->normals, cloud.normals) << name;
  }
}

TEST(MeshWriterTest, NamesTheEndingThatItDoesNotWrite) {
  const absl::Status status = WriteMesh("mesh.fbx", Irregular());
  EXPECT_EQ(status.message(),
            "mesh.fbx: its name ends with \".fbx\"; expected .obj, .ply, .off, .stl or .drc");
  EXPECT_EQ(WriteCloud("cloud", {}).code(), absl::StatusCode::kInvalidArgument);
}

}  // namespace
}  // namespace cagefit::client
