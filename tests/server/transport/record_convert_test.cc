#include "server/transport/record_convert.h"

#include <gtest/gtest.h>

#include "tests/server/session/session_fixture.h"
#include "tests/support/masks.h"

namespace cagefit::server {
namespace {

using testing::CageConfig;
using testing::DecodedFrame;
using testing::MovingFrame;
using testing::OpenSession;

const ProtoRecordCodec kCodec;

// Equal to the bit wherever a field has bits: both are encoded again.
void ExpectSame(const StoredFrame& frame) {
  const std::string bytes = kCodec.EncodeFrame(frame);
  const auto decoded = kCodec.DecodeFrame(bytes);
  ASSERT_TRUE(decoded.ok()) << decoded.status();
  EXPECT_EQ(kCodec.EncodeFrame(**decoded), bytes);
}

TEST(RecordConvertTest, AFittedFrameComesBackWhole) {
  OpenSession open(CageConfig());
  Frame sent = MovingFrame(0);
  sent.timestamp = absl::FromUnixSeconds(9) + absl::Nanoseconds(3);
  ASSERT_TRUE(open.Answer(std::move(sent)).ok());
  const StoredFrame& frame = open.Stored(0);
  const StoredFrame back = *kCodec.DecodeFrame(kCodec.EncodeFrame(frame)).value();
  EXPECT_EQ(back.sequence_number, frame.sequence_number);
  EXPECT_EQ(back.timestamp, frame.timestamp);
  EXPECT_EQ(back.digest, frame.digest);
  EXPECT_EQ(back.points, frame.points);
  EXPECT_EQ(back.outcome, Outcome::kFitted);
  EXPECT_EQ(back.delta.key, frame.delta.key);
  EXPECT_EQ(back.delta.grid.origin, frame.delta.grid.origin);
  EXPECT_EQ(back.delta.grid.quantum, frame.delta.grid.quantum);
  EXPECT_EQ(back.delta.values, frame.delta.values);
  EXPECT_EQ(back.delta.checksum, frame.delta.checksum);
  EXPECT_EQ(back.fit.final.distance, frame.fit.final.distance);
  EXPECT_EQ(back.fit.start, frame.fit.start);
  EXPECT_EQ(back.fit.samples, frame.fit.samples);
  EXPECT_EQ(back.fit.grown_samples, frame.fit.grown_samples);
  EXPECT_EQ(back.fit.noise, frame.fit.noise);
  EXPECT_EQ(back.distances.rms, frame.distances.rms);
  EXPECT_EQ(back.rms_percent, frame.rms_percent);
  EXPECT_EQ(back.verdict, frame.verdict);
  EXPECT_EQ(back.control_vertices, 42);
  EXPECT_EQ(back.first_box->min, frame.first_box->min);
  EXPECT_EQ(back.first_box->max, frame.first_box->max);
  EXPECT_EQ(back.StoredBytes(), frame.StoredBytes());
  ExpectSame(frame);
}

TEST(RecordConvertTest, EveryKindOfAnswerComesBack) {
  SessionConfig draco = CageConfig(), positions = CageConfig(), refined = CageConfig();
  draco.delta_encoding = DeltaEncoding::kDraco;
  positions.quantum = 0;
  refined.tolerance = ToleranceOptions{0.01, 0};
  refined.make_template.vertices = 200;
  for (const SessionConfig& config : {draco, positions, refined}) {
    OpenSession open(config);
    ASSERT_TRUE(open.Answer(MovingFrame(0)).ok());
    ASSERT_TRUE(open.Answer(DecodedFrame(1, "no Draco")).ok());
    ASSERT_TRUE(open.Answer(MovingFrame(2)).ok());
    for (const uint64_t number : {0, 1, 2}) ExpectSame(open.Stored(number));
    const StoredFrame& rejected = open.Stored(1);
    EXPECT_EQ(kCodec.DecodeFrame(kCodec.EncodeFrame(rejected)).value()->error, rejected.error);
  }
}

TEST(RecordConvertTest, ASkippedFrameComesBack) {
  StoredFrame skipped;
  skipped.sequence_number = 7;
  skipped.outcome = Outcome::kSkipped;
  skipped.digest.fill(5);
  ExpectSame(skipped);
  EXPECT_EQ(kCodec.DecodeFrame(kCodec.EncodeFrame(skipped)).value()->outcome, Outcome::kSkipped);
}

TEST(RecordConvertTest, AConfigurationComesBackWithEveryOptionInForce) {
  SessionConfig config = CageConfig();
  config.fit = FitOptions::Paper();
  config.fit.image.weight = 0.1 + 0.2;
  config.fit.distance.radius = 1.0 / 3;
  config.quantum = 1e-7;
  config.key_interval = 17;
  config.priority = Priority::kBatch;
  config.delta_encoding = DeltaEncoding::kDraco;
  config.cameras = {cagefit::testing::SmallCamera("left")};
  config.tolerance = ToleranceOptions{0.012345, 99};
  config.make_template = {1234, 45.5};
  const std::string bytes = kCodec.EncodeConfig(config);
  const SessionConfig back = kCodec.DecodeConfig(bytes).value();
  EXPECT_EQ(kCodec.EncodeConfig(back), bytes);
  EXPECT_EQ(back.name, config.name);
  EXPECT_EQ(back.priority, Priority::kBatch);
  EXPECT_FALSE(back.control_mesh.has_value());
  EXPECT_EQ(back.fit.solver.solver, config.fit.solver.solver);
  EXPECT_EQ(back.fit.image.weight, config.fit.image.weight);
  EXPECT_EQ(back.fit.distance.radius, config.fit.distance.radius);
  EXPECT_EQ(back.cameras[0].R, config.cameras[0].R);
  EXPECT_EQ(back.tolerance->tolerance, 0.012345);
  EXPECT_EQ(back.tolerance->max_vertices, 99);
  EXPECT_EQ(back.make_template.vertices, 1234);
  EXPECT_EQ(back.make_template.crease_angle_degrees, 45.5);
}

TEST(RecordConvertTest, AMeshComesBackWithItsCreases) {
  const ControlMesh cage = cagefit::testing::FrameCage();
  const auto tagged = ControlMesh::Create(
      cage.vertices(), cage.triangles(), {{{cage.triangles()(0, 0), cage.triangles()(1, 0)}}, {3}});
  ASSERT_TRUE(tagged.ok()) << tagged.status();
  const ControlMesh back = kCodec.DecodeMesh(kCodec.EncodeMesh(*tagged)).value();
  EXPECT_EQ(back.vertices(), tagged->vertices());
  EXPECT_EQ(back.triangles(), tagged->triangles());
  EXPECT_EQ(back.tags().edges, tagged->tags().edges);
  EXPECT_EQ(back.tags().corners, tagged->tags().corners);
}

TEST(RecordConvertTest, OtherBytesAreDataLoss) {
  for (const std::string& bytes : {std::string("\x0a\x05no"), std::string("\xff\xff")}) {
    EXPECT_TRUE(absl::IsDataLoss(kCodec.DecodeFrame(bytes).status()));
    EXPECT_TRUE(absl::IsDataLoss(kCodec.DecodeConfig(bytes).status()));
    EXPECT_TRUE(absl::IsDataLoss(kCodec.DecodeMesh(bytes).status()));
  }
  EXPECT_TRUE(absl::IsDataLoss(kCodec.DecodeFrame("").status()));
}

}  // namespace
}  // namespace cagefit::server
