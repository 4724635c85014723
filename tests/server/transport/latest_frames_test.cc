#include "server/transport/latest_frames.h"

#include <gtest/gtest.h>

namespace cagefit::server {
namespace {

std::shared_ptr<ReceivedFrame> FrameOf(uint64_t number, MemoryAccount* budget) {
  auto received =
      std::make_shared<ReceivedFrame>(ReceivedFrame{Frame(), MemoryReservation(budget)});
  EXPECT_TRUE(received->reservation.Grow(100).ok());
  received->frame.sequence_number = number;
  received->frame.digest[0] = static_cast<uint8_t>(number);
  return received;
}

TEST(LatestFramesTest, KeepsTheNewestAndWhatTheOthersAnswersNeed) {
  MemoryAccount budget("in flight", 1000);
  LatestFrames frames;
  for (uint64_t number = 5; number < 8; ++number) frames.Put(FrameOf(number, &budget));
  EXPECT_EQ(budget.taken(), 100) << "of the newest alone";
  const LatestFrames::Batch batch = frames.Take();
  ASSERT_EQ(batch.skipped.size(), 2u);
  for (uint64_t k = 0; k < 2; ++k) {
    EXPECT_EQ(batch.skipped[k].sequence_number, 5 + k);
    EXPECT_EQ(batch.skipped[k].digest[0], 5 + k);
  }
  ASSERT_NE(batch.newest, nullptr);
  EXPECT_EQ(batch.newest->frame.sequence_number, 7u);
}

TEST(LatestFramesTest, HasNothingOnceTaken) {
  MemoryAccount budget("in flight", 1000);
  LatestFrames frames;
  frames.Put(FrameOf(0, &budget));
  frames.Take();
  const LatestFrames::Batch empty = frames.Take();
  EXPECT_EQ(empty.newest, nullptr);
  EXPECT_TRUE(empty.skipped.empty());
}

}  // namespace
}  // namespace cagefit::server
