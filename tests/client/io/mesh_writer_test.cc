#include <gmock/gmock.h>

#include <random>

#include "client/io/geometry_file.h"
#include "tests/support/shapes.h"

namespace cagefit::client {
namespace {

std::string TempFile(const std::string& name) { return ::testing::TempDir() + name; }

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
