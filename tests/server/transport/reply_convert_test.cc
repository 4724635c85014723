#include "server/transport/reply_convert.h"

#include <gtest/gtest.h>

#include "tests/server/session/session_fixture.h"

namespace cagefit::server {
namespace {

using cagefit::testing::FrameCage;
using testing::CageConfig;
using testing::DecodedFrame;
using testing::MovingFrame;
using testing::OpenSession;

GridPoints Packed(const v1::VertexDelta& delta) {
  GridPoints q(3, delta.packed_size() / 3);
  std::copy(delta.packed().begin(), delta.packed().end(), q.data());
  return q;
}

TEST(ReplyConvertTest, AFittedFrameTellsEverything) {
  OpenSession open(CageConfig());
  Frame sent = MovingFrame(0);
  sent.timestamp = absl::FromUnixSeconds(9);
  const auto answer = open.Answer(std::move(sent));
  ASSERT_TRUE(answer.ok()) << answer.status();
  const StoredFrame& frame = *answer->frame;
  const v1::FrameReply reply = ToProto(*answer, *open.ledger);
  EXPECT_EQ(reply.sequence_number(), 0u);
  EXPECT_EQ(reply.timestamp().seconds(), 9);
  EXPECT_EQ(reply.outcome(), v1::OUTCOME_FITTED);
  EXPECT_FALSE(reply.repeated_reply());
  EXPECT_EQ(reply.initial_energies().distance(), frame.fit.initial.distance);
  EXPECT_EQ(reply.initial_energies().arap(), frame.fit.initial.arap);
  EXPECT_EQ(reply.final_energies().distance(), frame.fit.final.distance);
  EXPECT_EQ(reply.final_energies().arap(), frame.fit.final.arap);
  EXPECT_EQ(reply.final_energies().coverage(), frame.fit.final.coverage);
  EXPECT_EQ(reply.iterations(), static_cast<uint32_t>(frame.fit.iterations));
  EXPECT_EQ(reply.converged(), frame.fit.converged);
  EXPECT_EQ(reply.distances().mean(), frame.distances.mean);
  EXPECT_EQ(reply.distances().rms(), frame.distances.rms);
  EXPECT_EQ(reply.distances().max(), frame.distances.max);
  EXPECT_EQ(reply.distances().rms_percent(), frame.rms_percent);
  EXPECT_EQ(reply.distances().samples(), 500u);
  EXPECT_EQ(reply.verdict(), v1::VERDICT_OK);
  EXPECT_EQ(reply.radius(), frame.fit.radius);
  EXPECT_EQ(reply.radius_in_spacings(), frame.fit.radius_in_spacings);
  EXPECT_EQ(reply.points(), 500u);
  EXPECT_FALSE(reply.has_error());
  EXPECT_FALSE(reply.has_template_());
}

TEST(ReplyConvertTest, EveryEncodingOfADeltaArrives) {
  for (const auto& [encoding, quantum] :
       {std::pair(DeltaEncoding::kPacked, 1e-5), std::pair(DeltaEncoding::kDraco, 1e-5),
        std::pair(DeltaEncoding::kPacked, 0.0)}) {
    SessionConfig config = CageConfig();
    config.delta_encoding = encoding;
    config.quantum = quantum;
    OpenSession open(std::move(config));
    const auto answer = open.Answer(MovingFrame(0));
    ASSERT_TRUE(answer.ok()) << answer.status();
    const EncodedDelta& delta = answer->frame->delta;
    const v1::VertexDelta proto = ToProto(*answer, *open.ledger).delta();
    EXPECT_TRUE(proto.key());
    EXPECT_EQ(proto.crc32c(), delta.checksum);
    EXPECT_EQ(Packed(proto), delta.values);
    EXPECT_EQ(proto.draco(), delta.draco);
    EXPECT_EQ(proto.positions_size(), delta.positions.size());
    EXPECT_EQ(proto.quantum(), delta.grid.quantum);
    EXPECT_EQ(proto.origin_x(), delta.grid.origin.x());
    EXPECT_EQ(proto.origin_y(), delta.grid.origin.y());
    EXPECT_EQ(proto.origin_z(), delta.grid.origin.z());
    EXPECT_EQ(proto.packed_size() > 0, encoding == DeltaEncoding::kPacked && quantum > 0);
  }
}

TEST(ReplyConvertTest, ARejectedFrameHasAnErrorAndNoDelta) {
  OpenSession open(CageConfig());
  ASSERT_TRUE(open.Answer(DecodedFrame(0, "no Draco")).ok());
  const auto answer = open.Answer(DecodedFrame(0, "no Draco"));
  ASSERT_TRUE(answer.ok()) << answer.status();
  const v1::FrameReply reply = ToProto(*answer, *open.ledger);
  EXPECT_EQ(reply.outcome(), v1::OUTCOME_REJECTED);
  EXPECT_TRUE(reply.repeated_reply());
  EXPECT_EQ(reply.error().code(), static_cast<int>(absl::StatusCode::kInvalidArgument));
  EXPECT_EQ(reply.error().detail().reason(), "BAD_FRAME");
  EXPECT_FALSE(reply.has_delta());
  EXPECT_FALSE(reply.has_timestamp());
}

TEST(ReplyConvertTest, EveryVerdictHasItsName) {
  OpenSession open(CageConfig());
  for (const auto& [verdict, name] :
       {std::pair(Verdict::kOk, v1::VERDICT_OK), std::pair(Verdict::kSuspect, v1::VERDICT_SUSPECT),
        std::pair(Verdict::kLost, v1::VERDICT_LOST)}) {
    auto frame = std::make_shared<StoredFrame>();
    frame->outcome = Outcome::kFitted;
    frame->verdict = verdict;
    EXPECT_EQ(ToProto(FrameAnswer{frame}, *open.ledger).verdict(), name);
  }
}

TEST(ReplyConvertTest, CoverageNoiseAndOutliersAreTold) {
  OpenSession open(CageConfig());
  auto frame = std::make_shared<StoredFrame>();
  frame->outcome = Outcome::kFitted;
  frame->fit.initial.coverage = 3;
  frame->fit.final.coverage = 2;
  frame->fit.noise = 0.25;
  frame->fit.outliers = 7;
  const v1::FrameReply reply = ToProto(FrameAnswer{frame}, *open.ledger);
  EXPECT_EQ(reply.initial_energies().coverage(), 3);
  EXPECT_EQ(reply.final_energies().coverage(), 2);
  EXPECT_EQ(reply.noise(), 0.25);
  EXPECT_EQ(reply.outliers(), 7u);
}

TEST(ReplyConvertTest, WhatToleranceModeCameToIsTold) {
  OpenSession open(CageConfig());
  EXPECT_FALSE(ToProto(*open.Answer(MovingFrame(0)), *open.ledger).has_tolerance());
  for (const auto& [end, name] :
       {std::pair(ToleranceEnd::kWithin, v1::TOLERANCE_END_WITHIN),
        std::pair(ToleranceEnd::kVertexLimit, v1::TOLERANCE_END_VERTEX_LIMIT),
        std::pair(ToleranceEnd::kNoFurther, v1::TOLERANCE_END_NO_FURTHER)}) {
    auto frame = std::make_shared<StoredFrame>();
    frame->outcome = Outcome::kFitted;
    frame->control_vertices = 77;
    frame->tolerance = ToleranceReport{end, 0.5, {1, 2, 4}, /*diagonal=*/200, 77, 3};
    const v1::FrameReply reply = ToProto(FrameAnswer{frame}, *open.ledger);
    EXPECT_EQ(reply.control_vertices(), 77u);
    const v1::ToleranceReport& told = reply.tolerance();
    EXPECT_EQ(told.end(), name);
    EXPECT_EQ(told.tolerance(), 0.5);
    EXPECT_EQ(told.rms(), 1);
    EXPECT_EQ(told.most(), 2);
    EXPECT_EQ(told.max(), 4);
    EXPECT_EQ(told.rms_percent(), 0.5);
    EXPECT_EQ(told.most_percent(), 1);
    EXPECT_EQ(told.max_percent(), 2);
    EXPECT_EQ(told.control_vertices(), 77u);
    EXPECT_EQ(told.rounds(), 3u);
  }
}

TEST(ReplyConvertTest, TheFirstFrameBringsTheTemplateThatItMade) {
  SessionConfig config;
  config.make_template.vertices = 42;
  OpenSession open(std::move(config));
  open.templates.result = FrameCage();
  const v1::FrameReply first = ToProto(*open.Answer(MovingFrame(0)), *open.ledger);
  EXPECT_EQ(first.template_().triangles_size(), 240);
  EXPECT_EQ(first.template_().vertices_size(), 0);
  EXPECT_FALSE(ToProto(*open.Answer(MovingFrame(1)), *open.ledger).has_template_());
  EXPECT_TRUE(ToProto(*open.Answer(MovingFrame(0)), *open.ledger).has_template_());
}

}  // namespace
}  // namespace cagefit::server
