#include "client/retry_policy.h"

#include <gtest/gtest.h>

#include "absl/strings/cord.h"
#include "cagefit/v1/fitting.pb.h"
#include "client/status_from_grpc.h"

namespace cagefit::client {
namespace {

absl::Status Exhausted(absl::Duration retry_after) {
  v1::FrameError error;
  error.set_code(static_cast<int>(absl::StatusCode::kResourceExhausted));
  error.mutable_detail()->mutable_retry_after()->set_seconds(absl::ToInt64Seconds(retry_after));
  return FromProto(error);
}

// Time passes only where the test says so.
class RetryPolicyTest : public ::testing::Test {
 protected:
  RetryOptions Options() {
    RetryOptions options;
    options.now = [this] { return now_; };
    options.random = [this] { return random_; };
    return options;
  }

  absl::Time now_ = absl::UnixEpoch();
  double random_ = 0;
  const absl::Status gone_ = absl::UnavailableError("gone");
};

TEST_F(RetryPolicyTest, TriesAgainOnlyAfterWhatMayPass) {
  for (int code = 1; code <= 16; ++code) {
    RetryPolicy policy(Options());
    const bool may_pass = code == 2 || code == 4 || code == 8 || code == 13 || code == 14;
    const absl::Status failure(static_cast<absl::StatusCode>(code), "");
    EXPECT_EQ(policy.PauseAfter(failure).has_value(), may_pass) << failure;
  }
}

TEST_F(RetryPolicyTest, PausesDoubleUpToTheLongest) {
  RetryPolicy policy(Options());
  for (const int ms : {50, 100, 200, 400, 800, 1000, 1000}) {
    EXPECT_EQ(policy.PauseAfter(gone_), absl::Milliseconds(ms));
  }
  policy.Progress();
  EXPECT_EQ(policy.PauseAfter(gone_), absl::Milliseconds(50));
}

TEST_F(RetryPolicyTest, ChanceShortensAPauseByUpToAHalf) {
  RetryPolicy policy(Options());
  random_ = 0.5;
  EXPECT_EQ(policy.PauseAfter(gone_), absl::Milliseconds(37.5));
  RetryOptions by_chance = Options();
  by_chance.random = nullptr;
  const auto a = *RetryPolicy(by_chance).PauseAfter(gone_);
  const auto b = *RetryPolicy(by_chance).PauseAfter(gone_);
  EXPECT_NE(a, b);
  for (const absl::Duration pause : {a, b}) {
    EXPECT_GE(pause, absl::Milliseconds(25));
    EXPECT_LE(pause, absl::Milliseconds(50));
  }
}

TEST_F(RetryPolicyTest, GivesUpAfterTryingForLongEnough) {
  RetryPolicy policy(Options());
  int tries = 0;
  while (const auto pause = policy.PauseAfter(gone_)) {
    now_ += *pause;
    ++tries;
  }
  EXPECT_GT(tries, 50);
  EXPECT_GT(policy.tried_for(), absl::Seconds(58));
  EXPECT_LE(policy.tried_for(), absl::Seconds(60));
}

TEST_F(RetryPolicyTest, TimeOfAnOpenStreamDoesNotCount) {
  RetryPolicy policy(Options());
  for (int k = 0; k < 20; ++k) {
    ASSERT_TRUE(policy.PauseAfter(gone_).has_value()) << k;
    now_ += absl::Seconds(1);
    policy.Opened();
    now_ += absl::Minutes(20);
  }
  EXPECT_EQ(policy.tried_for(), absl::Seconds(20));
}

TEST_F(RetryPolicyTest, ProgressStartsTheTimeAgain) {
  RetryPolicy policy(Options());
  for (int k = 0; k < 20; ++k) {
    ASSERT_TRUE(policy.PauseAfter(gone_).has_value()) << k;
    now_ += absl::Seconds(30);
    policy.Opened();
    policy.Progress();
  }
}

TEST_F(RetryPolicyTest, WaitsAsLongAsTheServerSays) {
  RetryPolicy policy(Options());
  const auto pause = policy.PauseAfter(Exhausted(absl::Seconds(7)));
  ASSERT_TRUE(pause.has_value());
  EXPECT_GE(*pause, absl::Seconds(7));
  EXPECT_LE(*pause, absl::Seconds(8));
  EXPECT_FALSE(policy.PauseAfter(Exhausted(absl::Seconds(3600))).has_value());
}

TEST_F(RetryPolicyTest, ALimitThatStaysMetIsFinalSoon) {
  RetryPolicy policy(Options());
  const absl::Status refusal = absl::ResourceExhaustedError("the frame is too large");
  for (int k = 0; k < 5; ++k) EXPECT_TRUE(policy.PauseAfter(refusal).has_value());
  EXPECT_FALSE(policy.PauseAfter(refusal).has_value());
}

TEST_F(RetryPolicyTest, NothingIsTriedBeyondTheDeadline) {
  RetryOptions options = Options();
  options.deadline = now_ + absl::Seconds(5);
  RetryPolicy policy(options);
  const absl::Status late = absl::DeadlineExceededError("late");
  EXPECT_TRUE(policy.PauseAfter(late).has_value());
  now_ += absl::Seconds(5);
  EXPECT_FALSE(policy.PauseAfter(late).has_value());
}

}  // namespace
}  // namespace cagefit::client
