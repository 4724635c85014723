#include "server/session/byte_rate.h"

#include <gtest/gtest.h>

namespace cagefit::server {
namespace {

const absl::Time kStart = absl::FromUnixSeconds(1000);

TEST(ByteRateTest, WhatOneSecondAllowsPassesAtOnce) {
  ByteRate rate;
  EXPECT_EQ(rate.Take(1000, 1000, kStart), absl::ZeroDuration());
}

TEST(ByteRateTest, WhatIsBeyondHasToBeWaitedFor) {
  ByteRate rate;
  EXPECT_EQ(rate.Take(4000, 1000, kStart), absl::Seconds(3));
  EXPECT_EQ(rate.Take(0, 1000, kStart + absl::Seconds(1)), absl::Seconds(2));
  EXPECT_EQ(rate.Take(500, 1000, kStart + absl::Seconds(3)), absl::Milliseconds(500));
}

TEST(ByteRateTest, TimeWithoutBytesIsNotSavedUp) {
  ByteRate rate;
  EXPECT_EQ(rate.Take(0, 1000, kStart), absl::ZeroDuration());
  EXPECT_EQ(rate.Take(2000, 1000, kStart + absl::Hours(1)), absl::Seconds(1));
}

TEST(ByteRateTest, AClockThatIsSetBackPaysNothingOff) {
  ByteRate rate;
  rate.Take(3000, 1000, kStart);
  EXPECT_EQ(rate.Take(0, 1000, kStart - absl::Seconds(10)), absl::Seconds(2));
  EXPECT_EQ(rate.Take(0, 1000, kStart - absl::Seconds(9)), absl::Seconds(1));
}

TEST(ByteRateTest, ANewRatePaysAnOldDebtOff) {
  ByteRate rate;
  rate.Take(3000, 1000, kStart);
  EXPECT_EQ(rate.Take(0, 4000, kStart), absl::Milliseconds(500));
}

}  // namespace
}  // namespace cagefit::server
