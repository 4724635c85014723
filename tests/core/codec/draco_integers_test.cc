#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <random>

#include "core/codec/draco_codec.h"
#include "tests/core/codec/draco_samples.h"

namespace cagefit {
namespace {

GridPoints RandomGridPoints(int n, int32_t least, int32_t most) {
  std::mt19937 random(static_cast<unsigned>(n));
  std::uniform_int_distribution<int32_t> any(least, most);
  return GridPoints::NullaryExpr(3, n, [&] { return any(random); });
}

TEST(DracoIntegersTest, KeepOrderAndEveryBit) {
  constexpr int32_t kMin = std::numeric_limits<int32_t>::min();
  constexpr int32_t kMax = std::numeric_limits<int32_t>::max();
  for (const auto& [least, most] : {std::pair{0, 0},
                                    {-50, 50},
                                    {-1000, 99'000},
                                    {0, 1 << 20},
                                    {-1, 1 << 20},
                                    {-2, 1 << 30},
                                    {kMin, kMax},
                                    {kMin, kMin + 3},
                                    {kMax - 3, kMax}}) {
    for (int n : {1, 2, 314, 2562}) {
      const GridPoints values = RandomGridPoints(n, least, most);
      const auto bytes = EncodeDracoIntegers(values);
      ASSERT_TRUE(bytes.ok()) << bytes.status();
      const auto decoded = DecodeDracoIntegers(*bytes, n);
      ASSERT_TRUE(decoded.ok()) << decoded.status();
      ASSERT_EQ(*decoded, values) << "from " << least << " to " << most;
    }
  }
}

TEST(DracoIntegersTest, TakeAThirdOfTheRawSizeForDeltas) {
  std::mt19937 random(1);
  std::normal_distribution<double> step(0, 50);
  const GridPoints deltas = GridPoints::NullaryExpr(
      3, 2562, [&] { return static_cast<int32_t>(std::lround(step(random))); });
  EXPECT_LT(EncodeDracoIntegers(deltas).value().size(), 2562 * 12 / 3);
}

TEST(DracoIntegersTest, RefuseMoreVerticesThanExpected) {
  const std::string bytes = EncodeDracoIntegers(RandomGridPoints(100, -5, 5)).value();
  EXPECT_EQ(DecodeDracoIntegers(bytes, 99).status().code(), absl::StatusCode::kResourceExhausted);
}

TEST(DracoIntegersTest, RefuseOtherGeometry) {
  for (const testing::NamedBytes& sample : testing::AllDracoSamples()) {
    EXPECT_EQ(DecodeDracoIntegers(sample.bytes, 1000).status().code(),
              absl::StatusCode::kInvalidArgument)
        << sample.name;
  }
  EXPECT_EQ(EncodeDracoIntegers(GridPoints(3, 0)).status().code(),
            absl::StatusCode::kInvalidArgument);
}

}  // namespace
}  // namespace cagefit
