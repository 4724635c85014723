#include "core/codec/vertex_delta.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <random>

namespace cagefit {
namespace {

using ::testing::HasSubstr;

constexpr int32_t kMin = std::numeric_limits<int32_t>::min();
constexpr int32_t kMax = std::numeric_limits<int32_t>::max();

GridPoints RandomGridPoints(int n, std::mt19937* random) {
  std::uniform_int_distribution<int32_t> any(kMin, kMax);
  GridPoints q(3, n);
  for (Eigen::Index i = 0; i < q.size(); ++i) q.data()[i] = any(*random);
  return q;
}

// The bit-by-bit definition of CRC-32C (RFC 3720, reflected polynomial 0x82F63B78).
uint32_t Crc32cBitByBit(const unsigned char* bytes, size_t count) {
  uint32_t crc = 0xFFFFFFFFu;
  for (size_t i = 0; i < count; ++i) {
    crc ^= bytes[i];
    for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1) ^ ((crc & 1) ? 0x82F63B78u : 0u);
  }
  return ~crc;
}

TEST(ChecksumTest, IsCrc32cOfTheLittleEndianBytes) {
  ASSERT_EQ(Crc32cBitByBit(reinterpret_cast<const unsigned char*>("123456789"), 9), 0xE3069283u);
  std::mt19937 random(1);
  for (int n : {0, 1, 2, 7, 100}) {
    const GridPoints q = RandomGridPoints(n, &random);
    EXPECT_EQ(Checksum(q),
              Crc32cBitByBit(reinterpret_cast<const unsigned char*>(q.data()), 12 * n));
  }
}

TEST(ChecksumTest, AgreesWithThePublishedVectorOf32ZeroBytesExtendedTo36) {
  // RFC 3720 B.4 gives 0x8A9136AA for 32 zero bytes; 36 bytes are three vertices.
  const unsigned char zeros[36] = {};
  ASSERT_EQ(Crc32cBitByBit(zeros, 32), 0x8A9136AAu);
  EXPECT_EQ(Checksum(GridPoints::Zero(3, 3)), Crc32cBitByBit(zeros, 36));
}

TEST(QuantizeTest, TakesTheNearestGridPoint) {
  const VertexGrid grid{{1, 2, 3}, 0.25};
  Points3d x(3, 2);
  x << 1.0, 1.3,  //
      2.11, 1.0,  //
      2.8, 3.125;
  GridPoints expected(3, 2);
  expected << 0, 1,  //
      0, -4,         //
      -1, 1;
  EXPECT_EQ(Quantize(x, grid).value(), expected);
}

TEST(QuantizeTest, DequantizedGridPointsQuantizeToThemselves) {
  std::mt19937 random(2);
  const GridPoints q = RandomGridPoints(5000, &random);
  const VertexGrid grid{{-17.3, 0.004, 1e3}, 3.7e-6};
  EXPECT_EQ(Quantize(Dequantize(q, grid), grid).value(), q);
}

TEST(QuantizeTest, DequantizesWithOneRoundedProductAndOneRoundedSum) {
  const VertexGrid grid{{0.1, -0.7, 1e6}, 1.0 / 3.0};
  std::mt19937 random(3);
  const GridPoints q = RandomGridPoints(1000, &random);
  const Points3d x = Dequantize(q, grid);
  for (Eigen::Index j = 0; j < q.cols(); ++j) {
    for (int axis = 0; axis < 3; ++axis) {
      const volatile double product = grid.quantum * q(axis, j);
      const volatile double sum = product + grid.origin[axis];
      ASSERT_EQ(x(axis, j), sum);
    }
  }
}

TEST(QuantizeTest, ReachesBothEndsOfInt32AndNotBeyond) {
  const VertexGrid grid{{0, 0, 0}, 1.0};
  Points3d x(3, 1);
  x << kMin, kMax, 0;
  EXPECT_EQ(Quantize(x, grid).value()(0, 0), kMin);
  EXPECT_EQ(Quantize(x, grid).value()(1, 0), kMax);
  x(1, 0) = kMax + 1.0;
  EXPECT_EQ(Quantize(x, grid).status().code(), absl::StatusCode::kOutOfRange);
  x(1, 0) = 0;
  x(0, 0) = kMin - 1.0;
  EXPECT_EQ(Quantize(x, grid).status().code(), absl::StatusCode::kOutOfRange);
}

TEST(QuantizeTest, NamesTheVertexThatIsNotFinite) {
  Points3d x = Points3d::Zero(3, 9);
  for (double bad : {std::nan(""), HUGE_VAL, -HUGE_VAL}) {
    x(2, 6) = bad;
    const absl::Status status = Quantize(x, {{0, 0, 0}, 1e-5}).status();
    EXPECT_EQ(status.code(), absl::StatusCode::kOutOfRange);
    EXPECT_THAT(status.message(), HasSubstr("vertex 6: coordinate z"));
  }
}

TEST(QuantizeTest, RefusesAGridWithoutAQuantum) {
  for (double quantum : {0.0, -1.0, std::nan(""), HUGE_VAL}) {
    EXPECT_EQ(Quantize(Points3d::Zero(3, 1), {{0, 0, 0}, quantum}).status().code(),
              absl::StatusCode::kInvalidArgument);
  }
}

TEST(VertexDeltaTest, ReproducesAThousandFramesBitForBit) {
  std::mt19937 random(4);
  std::normal_distribution<double> step(0, 3e-3);
  const VertexGrid grid{{0.2, -0.5, 7.0}, 1e-5};
  Points3d truth = Points3d::Random(3, 300);
  GridPoints server = Quantize(truth, grid).value();
  GridPoints client;
  ASSERT_TRUE(ApplyDelta(EncodeKey(server), &client).ok());
  for (int frame = 0; frame < 1000; ++frame) {
    truth = truth.unaryExpr([&](double x) { return x + step(random); }).eval();
    const GridPoints after = Quantize(truth, grid).value();
    const VertexDelta delta = frame % 64 == 63 ? EncodeKey(after) : EncodeDelta(server, after);
    server = after;
    ASSERT_TRUE(ApplyDelta(delta, &client).ok());
    const Points3d x_server = Dequantize(server, grid), x_client = Dequantize(client, grid);
    ASSERT_EQ(std::memcmp(x_server.data(), x_client.data(), sizeof(double) * x_server.size()), 0);
    ASSERT_LE((x_client - truth).cwiseAbs().maxCoeff(), 0.5001 * grid.quantum);
  }
}

TEST(VertexDeltaTest, WrapsAroundBetweenAnyTwoStates) {
  GridPoints low = GridPoints::Constant(3, 2, kMin), high = GridPoints::Constant(3, 2, kMax);
  EXPECT_EQ(EncodeDelta(low, high).values, GridPoints::Constant(3, 2, -1));
  std::mt19937 random(5);
  for (int i = 0; i < 100; ++i) {
    const GridPoints before = RandomGridPoints(20, &random), after = RandomGridPoints(20, &random);
    GridPoints state = before;
    ASSERT_TRUE(ApplyDelta(EncodeDelta(before, after), &state).ok());
    ASSERT_EQ(state, after);
  }
  ASSERT_TRUE(ApplyDelta(EncodeDelta(low, high), &low).ok());
  EXPECT_EQ(low, high);
}

TEST(VertexDeltaTest, LeavesTheStateAloneWhenTheChecksumDiffers) {
  std::mt19937 random(6);
  const GridPoints before = RandomGridPoints(20, &random), after = RandomGridPoints(20, &random);
  VertexDelta delta = EncodeDelta(before, after);
  delta.values(1, 3) ^= 1;
  GridPoints state = before;
  EXPECT_EQ(ApplyDelta(delta, &state).code(), absl::StatusCode::kDataLoss);
  EXPECT_EQ(state, before);
  VertexDelta key = EncodeKey(after);
  key.checksum ^= 0x80000000u;
  EXPECT_EQ(ApplyDelta(key, &state).code(), absl::StatusCode::kDataLoss);
  EXPECT_EQ(state, before);
}

TEST(VertexDeltaTest, RefusesADeltaOfAnotherSize) {
  GridPoints state = GridPoints::Zero(3, 4);
  const VertexDelta delta = EncodeDelta(GridPoints::Zero(3, 5), GridPoints::Ones(3, 5));
  const absl::Status status = ApplyDelta(delta, &state);
  EXPECT_EQ(status.code(), absl::StatusCode::kDataLoss);
  EXPECT_THAT(status.message(), HasSubstr("5 vertices for a state of 4"));
  EXPECT_EQ(state, GridPoints::Zero(3, 4));
}

}  // namespace
}  // namespace cagefit
