#include "server/session/fit_share.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <vector>

namespace cagefit::server {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

// A pool that runs a task when the test says so.
class FitShareTest : public ::testing::Test {
 protected:
  absl::Status Run(int64_t limit, int name) {
    return share_->Run(
        limit,
        [this](FitShare::Task task) {
          if (full_) return absl::ResourceExhaustedError("full");
          submitted_.push_back(std::move(task));
          return absl::OkStatus();
        },
        [this, name] { ran_.push_back(name); },
        [this, name](const absl::Status&) { refused_.push_back(name); });
  }
  void RunSubmitted(size_t k) {
    const FitShare::Task task = std::move(submitted_[k]);
    task();
  }

  std::shared_ptr<FitShare> share_ = std::make_shared<FitShare>();
  bool full_ = false;
  std::vector<FitShare::Task> submitted_;
  std::vector<int> ran_, refused_;
};

TEST_F(FitShareTest, OnlyTheLimitIsSubmittedAndTheRestWaitsInOrder) {
  for (int name = 0; name < 5; ++name) ASSERT_TRUE(Run(2, name).ok());
  EXPECT_EQ(submitted_.size(), 2u);
  for (size_t k = 0; k < 5; ++k) {
    ASSERT_LT(k, submitted_.size());
    RunSubmitted(k);
  }
  EXPECT_THAT(ran_, ElementsAre(0, 1, 2, 3, 4));
  EXPECT_EQ(submitted_.size(), 5u);
}

TEST_F(FitShareTest, APlaceIsFreeOnceATaskHasEnded) {
  ASSERT_TRUE(Run(1, 0).ok());
  RunSubmitted(0);
  ASSERT_TRUE(Run(1, 1).ok());
  EXPECT_EQ(submitted_.size(), 2u);
}

TEST_F(FitShareTest, ANewcomerDoesNotOvertakeThoseThatWait) {
  for (int name = 0; name < 3; ++name) ASSERT_TRUE(Run(1, name).ok());
  ASSERT_TRUE(Run(2, 3).ok());  // the limit was raised, but two were here before
  RunSubmitted(0);
  ASSERT_EQ(submitted_.size(), 3u);
  RunSubmitted(1);
  RunSubmitted(2);
  ASSERT_EQ(submitted_.size(), 4u);
  RunSubmitted(3);
  EXPECT_THAT(ran_, ElementsAre(0, 1, 2, 3));
}

TEST_F(FitShareTest, ARefusalOfThePoolIsTheCallersAndTakesNoPlace) {
  full_ = true;
  EXPECT_TRUE(absl::IsResourceExhausted(Run(1, 0)));
  EXPECT_THAT(refused_, IsEmpty());
  full_ = false;
  ASSERT_TRUE(Run(1, 1).ok());
  EXPECT_EQ(submitted_.size(), 1u);
}

TEST_F(FitShareTest, ATaskThatWaitedLearnsOfARefusalAndTakesNoPlace) {
  for (int name = 0; name < 3; ++name) ASSERT_TRUE(Run(1, name).ok());
  full_ = true;
  RunSubmitted(0);
  EXPECT_THAT(refused_, ElementsAre(1, 2));
  full_ = false;
  ASSERT_TRUE(Run(1, 3).ok());
  EXPECT_EQ(submitted_.size(), 2u);
}

TEST_F(FitShareTest, TooManyThatWaitAreExhaustion) {
  for (int k = 0; k < 1 + FitShare::kMaxWaiting; ++k) ASSERT_TRUE(Run(1, k).ok());
  EXPECT_TRUE(absl::IsResourceExhausted(Run(1, -1)));
}

}  // namespace
}  // namespace cagefit::server
