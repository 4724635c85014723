#include "client/mesh_from_proto.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/frames.h"

namespace cagefit::client {
namespace {

using cagefit::testing::FrameCage;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

TEST(MeshFromProtoTest, ComesBackToTheBit) {
  const ControlMesh cage = FrameCage();
  const ControlMesh mesh =
      ControlMesh::Create(cage.vertices(), cage.triangles(),
                          {{{cage.triangles()(0, 5), cage.triangles()(1, 5)}}, {7, 9}})
          .value();
  const auto back = FromProto(ToProto(mesh));
  ASSERT_TRUE(back.ok()) << back.status();
  EXPECT_EQ(back->vertices(), mesh.vertices());
  EXPECT_EQ(back->triangles(), mesh.triangles());
  EXPECT_EQ(back->tags().edges, mesh.tags().edges);
  EXPECT_THAT(back->tags().corners, ElementsAre(7, 9));
}

TEST(MeshFromProtoTest, ListsThatAreCutOffAreDataLoss) {
  v1::ControlMesh vertices = ToProto(FrameCage()), triangles = vertices, edges = vertices;
  vertices.add_vertices(1);
  triangles.add_triangles(1);
  edges.add_crease_edges(1);
  for (const v1::ControlMesh& proto : {vertices, triangles, edges}) {
    EXPECT_TRUE(absl::IsDataLoss(FromProto(proto).status())) << FromProto(proto).status();
  }
}

TEST(MeshFromProtoTest, AMeshThatIsNotValidIsDataLossAndSaysWhy) {
  for (const uint32_t index : {42u, 0x80000000u, 0xFFFFFFFFu}) {
    v1::ControlMesh proto = ToProto(FrameCage());
    proto.set_triangles(0, index);
    const absl::Status status = FromProto(proto).status();
    EXPECT_TRUE(absl::IsDataLoss(status)) << status;
    EXPECT_THAT(std::string(status.message()), HasSubstr("control mesh: "));
  }
}

}  // namespace
}  // namespace cagefit::client
