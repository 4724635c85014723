#include "server/session/stored_frame.h"

#include <gtest/gtest.h>

#include <limits>
#include <random>

namespace cagefit::server {
namespace {

GridPoints RandomGridPoints(int n, uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_int_distribution<int32_t> any(std::numeric_limits<int32_t>::min(),
                                             std::numeric_limits<int32_t>::max());
  return GridPoints::NullaryExpr(3, n, [&] { return any(random); });
}

TEST(StoredFrameTest, DeltasComeBackToTheBitInBothEncodings) {
  const VertexGrid grid{{1, 2, 3}, 1e-5};
  const GridPoints before = RandomGridPoints(50, 1), after = RandomGridPoints(50, 2);
  for (const DeltaEncoding encoding : {DeltaEncoding::kPacked, DeltaEncoding::kDraco}) {
    for (const VertexDelta& delta : {EncodeKey(after), EncodeDelta(before, after)}) {
      const auto encoded = Encode(delta, grid, encoding);
      ASSERT_TRUE(encoded.ok()) << encoded.status();
      EXPECT_EQ(encoded->draco.empty(), encoding == DeltaEncoding::kPacked);
      EXPECT_EQ(encoded->values.size() == 0, encoding == DeltaEncoding::kDraco);
      EXPECT_EQ(encoded->grid.origin, grid.origin);
      EXPECT_EQ(encoded->grid.quantum, grid.quantum);
      const auto decoded = Decode(*encoded, 50);
      ASSERT_TRUE(decoded.ok()) << decoded.status();
      EXPECT_EQ(decoded->key, delta.key);
      EXPECT_EQ(decoded->values, delta.values);
      EXPECT_EQ(decoded->checksum, delta.checksum);
    }
  }
}

TEST(StoredFrameTest, MoreCompressedVerticesThanExpectedAreAnError) {
  const auto encoded =
      Encode(EncodeKey(RandomGridPoints(50, 3)), VertexGrid(), DeltaEncoding::kDraco);
  ASSERT_TRUE(encoded.ok()) << encoded.status();
  EXPECT_FALSE(Decode(*encoded, 49).ok());
}

TEST(StoredFrameTest, PositionsAreAKeyFrameWithAChecksumOfTheirBits) {
  // 32 zero bytes have 0x8A9136AA (RFC 3720 B.4); here are 36, as the integer 0 has them.
  EXPECT_EQ(EncodePositions(Points3f::Zero(3, 3)).checksum, Checksum(GridPoints::Zero(3, 3)));
  const EncodedDelta one = EncodePositions(Points3f::Constant(3, 3, 1.0f));
  EXPECT_EQ(one.checksum, Checksum(GridPoints::Constant(3, 3, 0x3F800000)));
  EXPECT_TRUE(one.key);
  EXPECT_EQ(one.positions, Points3f::Constant(3, 3, 1.0f));
}

TEST(StoredFrameTest, StoredBytesCountWhatAFrameHolds) {
  StoredFrame frame;
  const int64_t empty = frame.StoredBytes();
  EXPECT_GT(empty, 0);
  frame.delta.values = GridPoints::Zero(3, 100);
  EXPECT_EQ(frame.StoredBytes(), empty + 1200);
  frame.delta = EncodePositions(Points3f::Zero(3, 100));
  EXPECT_EQ(frame.StoredBytes(), empty + 1200);
  frame.delta = EncodedDelta();
  frame.delta.draco.assign(77, 'x');
  EXPECT_EQ(frame.StoredBytes(), empty + 77);
}

}  // namespace
}  // namespace cagefit::server
