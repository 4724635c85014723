#include "server/transport/loss_convert.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "server/session/error_detail.h"

namespace cagefit::server {
namespace {

using ::testing::ElementsAre;

TEST(LossConvertTest, StencilsAreCompressedRows) {
  ExportedStencils stencils;
  stencils.S.resize(3, 4);
  stencils.S.insert(0, 1) = 0.25;
  stencils.S.insert(0, 3) = 0.75;
  stencils.S.insert(2, 0) = 1;
  stencils.S.makeCompressed();
  stencils.triangles.resize(3, 1);
  stencils.triangles << 2, 0, 1;
  const v1::Stencils proto = ToProto(stencils);
  EXPECT_EQ(proto.rows(), 3u);
  EXPECT_EQ(proto.columns(), 4u);
  EXPECT_THAT(proto.row_begin(), ElementsAre(0, 2, 2, 3));
  EXPECT_THAT(proto.column(), ElementsAre(1, 3, 0));
  EXPECT_THAT(proto.value(), ElementsAre(0.25, 0.75, 1));
  EXPECT_THAT(proto.triangles(), ElementsAre(2, 0, 1));
}

TEST(LossConvertTest, ARequestArrivesWithItsFrame) {
  v1::EvaluateLossRequest request;
  request.set_session_id("id");
  for (int k = 0; k < 6; ++k) request.add_vertices(k);
  const auto bare = FromProto(&request);
  ASSERT_TRUE(bare.ok()) << bare.status();
  EXPECT_EQ(bare->session_id, "id");
  EXPECT_EQ(bare->vertices.col(1), Eigen::Vector3d(3, 4, 5));
  EXPECT_FALSE(bare->frame.has_value());

  request.mutable_frame()->set_data("bytes");
  request.mutable_frame()->set_point_count(7);
  request.mutable_frame()->add_masks()->set_camera("left");
  const auto query = FromProto(&request);
  ASSERT_TRUE(query.ok()) << query.status();
  EXPECT_EQ(query->frame->bytes, "bytes");
  EXPECT_EQ(query->frame->point_count, 7u);
  ASSERT_EQ(query->frame->stated_masks.size(), 1u);
  EXPECT_EQ(query->frame->stated_masks[0].camera, "left");
}

TEST(LossConvertTest, RefusesVerticesThatAreCutOffAndUnknownEncodings) {
  v1::EvaluateLossRequest request;
  request.add_vertices(1);
  EXPECT_EQ(DetailOf(FromProto(&request).status())->field, "vertices");
  request.clear_vertices();
  request.mutable_frame()->set_encoding(static_cast<v1::FrameEncoding>(9));
  EXPECT_EQ(DetailOf(FromProto(&request).status())->field, "frame.encoding");
}

TEST(LossConvertTest, ALossKeepsTheOrderOfTheVertices) {
  Loss loss;
  loss.energies.distance = 1;
  loss.energies.arap = 2;
  loss.energies.coverage = 4;
  loss.gradient.resize(3, 2);
  loss.gradient << 1, 4, 2, 5, 3, 6;
  const v1::EvaluateLossReply reply = ToProto(loss);
  EXPECT_EQ(reply.energies().arap(), 2);
  EXPECT_EQ(reply.total(), 7);
  EXPECT_THAT(reply.gradient(), ElementsAre(1, 2, 3, 4, 5, 6));
}

}  // namespace
}  // namespace cagefit::server
