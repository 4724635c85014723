#include "server/session/fail_plan.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>

namespace cagefit::server {
namespace {

using ::testing::HasSubstr;
using ::testing::SizeIs;
using Kind = FailAction::Kind;

// Which of the first `hits` passes of point "p" fail: '!' or '.'.
std::string Passes(const std::string& text, int hits) {
  FailPlan plan;
  EXPECT_EQ(plan.Parse(text), absl::OkStatus());
  std::string passes;
  for (int k = 0; k < hits; ++k) passes += plan.Hit("p", k).empty() ? '.' : '!';
  return passes;
}

TEST(FailPlanTest, WithoutAnEntryNothingFails) { EXPECT_EQ(Passes("", 3), "..."); }

TEST(FailPlanTest, FailsEachTimeWithoutAWhen) { EXPECT_EQ(Passes("p=kill", 3), "!!!"); }

TEST(FailPlanTest, FailsTheNthTime) { EXPECT_EQ(Passes("p=kill@2", 4), ".!.."); }

TEST(FailPlanTest, FailsForAKey) { EXPECT_EQ(Passes("p=kill@#3", 5), "...!."); }

TEST(FailPlanTest, FailsWithAProbabilityThatTheSeedDecides) {
  const std::string passes = Passes("seed=1,p=kill@p0.25", 400);
  EXPECT_NEAR(static_cast<double>(std::count(passes.begin(), passes.end(), '!')), 100, 40);
  EXPECT_EQ(Passes("seed=1,p=kill@p0.25", 400), passes);
  EXPECT_NE(Passes("seed=2,p=kill@p0.25", 400), passes);
}

TEST(FailPlanTest, OtherPointsDoNotFail) {
  FailPlan plan;
  ASSERT_EQ(plan.Parse("p=kill"), absl::OkStatus());
  EXPECT_THAT(plan.Hit("q", 0), SizeIs(0));
}

TEST(FailPlanTest, ReadsEveryAction) {
  FailPlan plan;
  ASSERT_EQ(plan.Parse("p=kill,p=abort,p=error:DATA_LOSS,p=delay:20"), absl::OkStatus());
  const auto actions = plan.Hit("p", 0);
  ASSERT_THAT(actions, SizeIs(4));
  EXPECT_EQ(actions[0].kind, Kind::kKill);
  EXPECT_EQ(actions[1].kind, Kind::kAbort);
  EXPECT_EQ(actions[2].kind, Kind::kError);
  EXPECT_EQ(actions[2].code, absl::StatusCode::kDataLoss);
  EXPECT_EQ(actions[3].kind, Kind::kDelay);
  EXPECT_EQ(actions[3].delay_ms, 20);
}

TEST(FailPlanTest, NamesWhatItDoesNotUnderstand) {
  for (const char* text :
       {"p", "p=", "p=explode", "p=kill:3", "p=error", "p=error:OOPS", "p=delay", "p=delay:-1",
        "p=kill@", "p=kill@x", "p=kill@p2", "p=kill@#", "seed=x"}) {
    FailPlan plan;
    const absl::Status status = plan.Parse(std::string("q=kill,") + text);
    EXPECT_TRUE(absl::IsInvalidArgument(status)) << text << ": " << status;
    EXPECT_THAT(std::string(status.message()), HasSubstr(std::string(text).substr(0, 4))) << text;
  }
}

}  // namespace
}  // namespace cagefit::server
