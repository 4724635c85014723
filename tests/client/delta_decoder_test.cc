#include "client/delta_decoder.h"

#include <gtest/gtest.h>

#include <cstring>
#include <limits>
#include <random>

#include "core/codec/draco_codec.h"

namespace cagefit::client {
namespace {

constexpr int kVertices = 30;

GridPoints RandomGridPoints(uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_int_distribution<int32_t> any(std::numeric_limits<int32_t>::min(),
                                             std::numeric_limits<int32_t>::max());
  return GridPoints::NullaryExpr(3, kVertices, [&] { return any(random); });
}

VertexGrid Grid() { return {{1.1, -2.2, 3.3}, 1.0 / 3.0}; }

v1::VertexDelta Header(const VertexDelta& delta) {
  v1::VertexDelta proto;
  proto.set_key(delta.key);
  proto.set_origin_x(Grid().origin.x());
  proto.set_origin_y(Grid().origin.y());
  proto.set_origin_z(Grid().origin.z());
  proto.set_quantum(Grid().quantum);
  proto.set_crc32c(delta.checksum);
  return proto;
}

v1::VertexDelta Packed(const VertexDelta& delta) {
  v1::VertexDelta proto = Header(delta);
  proto.mutable_packed()->Add(delta.values.data(), delta.values.data() + delta.values.size());
  return proto;
}

v1::VertexDelta Compressed(const VertexDelta& delta) {
  v1::VertexDelta proto = Header(delta);
  proto.set_draco(EncodeDracoIntegers(delta.values).value());
  return proto;
}

v1::VertexDelta Positions(const Points3f& positions) {
  v1::VertexDelta proto;
  proto.set_key(true);
  proto.mutable_positions()->Add(positions.data(), positions.data() + positions.size());
  GridPoints bits(3, positions.cols());
  std::memcpy(bits.data(), positions.data(), positions.size() * sizeof(float));
  proto.set_crc32c(Checksum(bits));
  return proto;
}

TEST(DeltaDecoderTest, HasNoVerticesBeforeTheFirstDelta) {
  EXPECT_EQ(DeltaDecoder().vertices().cols(), 0);
}

TEST(DeltaDecoderTest, FollowsKeyFramesAndDifferencesInBothEncodings) {
  for (const auto encode : {Packed, Compressed}) {
    DeltaDecoder decoder;
    GridPoints before = RandomGridPoints(1);
    ASSERT_EQ(decoder.Apply(encode(EncodeKey(before))), absl::OkStatus());
    EXPECT_EQ(decoder.vertices(), Dequantize(before, Grid()));
    for (uint32_t seed = 2; seed < 6; ++seed) {
      const GridPoints after = RandomGridPoints(seed);
      ASSERT_EQ(decoder.Apply(encode(EncodeDelta(before, after))), absl::OkStatus());
      EXPECT_EQ(decoder.vertices(), Dequantize(after, Grid()));
      before = after;
    }
  }
}

TEST(DeltaDecoderTest, AKeyFrameNeedsNoStateBefore) {
  DeltaDecoder decoder;
  ASSERT_TRUE(decoder.Apply(Packed(EncodeKey(RandomGridPoints(1)))).ok());
  ASSERT_TRUE(decoder.Apply(Packed(EncodeKey(RandomGridPoints(7)))).ok());
  EXPECT_EQ(decoder.vertices(), Dequantize(RandomGridPoints(7), Grid()));
}

TEST(DeltaDecoderTest, TakesPositionsAsTheyAre) {
  DeltaDecoder decoder;
  const Points3f positions = RandomGridPoints(1).cast<float>() * 1e-7f;
  ASSERT_EQ(decoder.Apply(Positions(positions)), absl::OkStatus());
  EXPECT_EQ(decoder.vertices(), positions.cast<double>());
}

// Applies a broken delta after a good key frame: it must not change the vertices.
void ExpectDataLoss(const v1::VertexDelta& broken) {
  DeltaDecoder decoder;
  const GridPoints good = RandomGridPoints(1);
  ASSERT_TRUE(decoder.Apply(Packed(EncodeKey(good))).ok());
  const absl::Status status = decoder.Apply(broken);
  EXPECT_TRUE(absl::IsDataLoss(status)) << status;
  EXPECT_EQ(decoder.vertices(), Dequantize(good, Grid()));
  const GridPoints next = RandomGridPoints(9);
  EXPECT_EQ(decoder.Apply(Packed(EncodeDelta(good, next))), absl::OkStatus());
  EXPECT_EQ(decoder.vertices(), Dequantize(next, Grid()));
}

TEST(DeltaDecoderTest, AWrongChecksumIsDataLoss) {
  v1::VertexDelta delta = Packed(EncodeDelta(RandomGridPoints(1), RandomGridPoints(2)));
  delta.set_crc32c(delta.crc32c() ^ 1);
  ExpectDataLoss(delta);
  v1::VertexDelta positions = Positions(Points3f::Ones(3, kVertices));
  positions.set_positions(5, 1.5f);
  ExpectDataLoss(positions);
}

TEST(DeltaDecoderTest, AMissedDifferenceIsDataLoss) {
  ExpectDataLoss(Packed(EncodeDelta(RandomGridPoints(2), RandomGridPoints(3))));
}

TEST(DeltaDecoderTest, ADifferenceWithoutAnyStateIsDataLoss) {
  DeltaDecoder decoder;
  EXPECT_TRUE(absl::IsDataLoss(
      decoder.Apply(Packed(EncodeDelta(RandomGridPoints(1), RandomGridPoints(2))))));
  EXPECT_EQ(decoder.vertices().cols(), 0);
}

TEST(DeltaDecoderTest, ListsThatAreCutOffAreDataLoss) {
  v1::VertexDelta packed = Packed(EncodeDelta(RandomGridPoints(1), RandomGridPoints(2)));
  packed.mutable_packed()->RemoveLast();
  ExpectDataLoss(packed);
  v1::VertexDelta fewer = Packed(EncodeDelta(RandomGridPoints(1), RandomGridPoints(2)));
  for (int k = 0; k < 3; ++k) fewer.mutable_packed()->RemoveLast();
  ExpectDataLoss(fewer);
  v1::VertexDelta positions = Positions(Points3f::Ones(3, kVertices));
  positions.mutable_positions()->RemoveLast();
  ExpectDataLoss(positions);
}

TEST(DeltaDecoderTest, BytesThatAreNotDracoLeaveTheStateAsItWas) {
  DeltaDecoder decoder;
  ASSERT_TRUE(decoder.Apply(Packed(EncodeKey(RandomGridPoints(1)))).ok());
  v1::VertexDelta delta = Header(EncodeKey(RandomGridPoints(2)));
  delta.set_draco("no Draco");
  EXPECT_FALSE(decoder.Apply(delta).ok());
  EXPECT_EQ(decoder.vertices(), Dequantize(RandomGridPoints(1), Grid()));
}

}  // namespace
}  // namespace cagefit::client
