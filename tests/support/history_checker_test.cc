#include "tests/support/history_checker.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace cagefit::testing {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

const std::vector<std::string> kUndisturbed = {"a", "b", "c"};

// Two streams: the first broke after frame 0 was answered and frame 1 was stored.
History GoodHistory() {
  History history;
  history.Opened(0, 1);
  history.Sent(0);
  history.Sent(1);
  history.Answered(0, "a");
  history.Opened(2, 2);
  history.Sent(1);
  history.Sent(2);
  history.Answered(1, "b");
  history.Answered(2, "c");
  return history;
}

TEST(HistoryCheckerTest, FindsNothingWhereEachFrameIsAnsweredOnceInOrder) {
  EXPECT_THAT(CheckHistory(GoodHistory(), kUndisturbed), IsEmpty());
}

TEST(HistoryCheckerTest, AFrameThatIsAnsweredTwiceIsFound) {
  History history = GoodHistory();
  history.Answered(1, "b");
  EXPECT_THAT(CheckHistory(history, kUndisturbed), ElementsAre("frame 1 is answered twice"));
}

TEST(HistoryCheckerTest, AMissingFrameIsFound) {
  EXPECT_THAT(CheckHistory(GoodHistory(), {"a", "b", "c", "d"}),
              ElementsAre("frame 3 is missing: it was never answered"));
}

TEST(HistoryCheckerTest, AFrameOutOfOrderIsFound) {
  History history;
  history.Opened(0, 1);
  history.Sent(0);
  history.Sent(1);
  history.Answered(1, "b");
  history.Answered(0, "a");
  EXPECT_THAT(CheckHistory(history, {"a", "b"}),
              ElementsAre("frame 0 is answered out of order, after frame 1"));
}

TEST(HistoryCheckerTest, OtherBitsAreFound) {
  EXPECT_THAT(CheckHistory(GoodHistory(), {"a", "B", "c"}),
              ElementsAre("frame 1 differs from the undisturbed run"));
}

TEST(HistoryCheckerTest, AnAnsweredFrameThatTheServerLostIsFound) {
  History history = GoodHistory();
  history.Opened(2, 3);
  EXPECT_THAT(CheckHistory(history, kUndisturbed),
              ElementsAre("frame 2 was answered and is lost: the server goes on at 2"));
}

TEST(HistoryCheckerTest, AServerThatIsAheadOfItsClientIsFound) {
  History history = GoodHistory();
  history.Opened(4, 3);
  EXPECT_THAT(CheckHistory(history, kUndisturbed),
              ElementsAre("the server goes on at 4 but only 3 frames were sent"));
}

TEST(HistoryCheckerTest, AnAnswerToAFrameThatWasNotSentIsFound) {
  History history;
  history.Opened(0, 1);
  history.Answered(0, "a");
  EXPECT_THAT(CheckHistory(history, {"a"}), ElementsAre("frame 0 is answered but was not sent"));
}

TEST(HistoryCheckerTest, AnAnswerBehindTheSequenceIsFound) {
  History history = GoodHistory();
  history.Sent(3);
  history.Answered(3, "d");
  EXPECT_THAT(CheckHistory(history, kUndisturbed),
              ElementsAre("frame 3 is answered; the sequence has 3"));
}

TEST(HistoryCheckerTest, AnEpochThatDoesNotRiseIsFound) {
  History history = GoodHistory();
  history.Opened(3, 2);
  EXPECT_THAT(CheckHistory(history, kUndisturbed), ElementsAre("epoch 2 comes after epoch 2"));
}

TEST(HistoryCheckerTest, BitsDifferWhereOneBitDiffers) {
  Points3d vertices = Points3d::Zero(3, 2);
  const std::string before = BitsOf(vertices);
  vertices(2, 1) = -0.0;
  EXPECT_EQ(before.size(), 48u);
  EXPECT_NE(BitsOf(vertices), before);
}

}  // namespace
}  // namespace cagefit::testing
