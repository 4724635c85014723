#include "client/commands/parse_tolerance.h"

#include <gmock/gmock.h>

namespace cagefit::client {
namespace {

using ::testing::HasSubstr;

TEST(ParseToleranceTest, ReadsPercentagesAndShares) {
  for (const char* text : {"0.1%", "0.1 %", " 0.1% ", ".1%", "1e-1%", "0.001", "1e-3"}) {
    const auto share = ParseTolerance(text);
    ASSERT_TRUE(share.ok()) << text << ": " << share.status();
    EXPECT_DOUBLE_EQ(*share, 0.001) << text;
  }
  EXPECT_DOUBLE_EQ(*ParseTolerance("10%"), 0.1);
  EXPECT_DOUBLE_EQ(*ParseTolerance("0.01"), 0.01);
}

TEST(ParseToleranceTest, RefusesWhatIsNoToleranceQuotingIt) {
  for (const char* text : {"", "%", "fine", "0.1%%", "0.1mm", "0,1%", "1 2%", "0", "0%", "-0.1%",
                           "11%", "nan", "inf%"}) {
    const auto share = ParseTolerance(text);
    EXPECT_TRUE(absl::IsInvalidArgument(share.status())) << text;
    EXPECT_THAT(std::string(share.status().message()), HasSubstr("\"" + std::string(text) + "\""));
  }
}

TEST(ParseToleranceTest, AsksForTheSignWhereAShareIsLargeEnoughToBeAPercentage) {
  const auto share = ParseTolerance("0.1");
  EXPECT_TRUE(absl::IsInvalidArgument(share.status()));
  EXPECT_THAT(std::string(share.status().message()), HasSubstr("write 0.1% or 10%"));
}

}  // namespace
}  // namespace cagefit::client
