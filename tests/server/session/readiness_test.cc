#include "server/session/readiness.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <thread>

namespace cagefit::server {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

TEST(ReadinessTest, IsReadyUnlessSomethingNamesAReason) {
  Readiness readiness;
  EXPECT_TRUE(readiness.is_ready());
  readiness.Set("store");
  EXPECT_FALSE(readiness.is_ready());
  readiness.Clear("store");
  EXPECT_TRUE(readiness.is_ready());
}

TEST(ReadinessTest, OneReasonIsEnough) {
  Readiness readiness;
  readiness.Set("store");
  readiness.Set("draining");
  EXPECT_THAT(readiness.Reasons(), ElementsAre("draining", "store"));
  readiness.Clear("store");
  EXPECT_FALSE(readiness.is_ready());
  readiness.Clear("draining");
  EXPECT_TRUE(readiness.is_ready());
  EXPECT_THAT(readiness.Reasons(), IsEmpty());
}

TEST(ReadinessTest, AReasonThatIsSetTwiceIsClearedOnce) {
  Readiness readiness;
  readiness.Set("store");
  readiness.Set("store");
  readiness.Clear("store");
  EXPECT_TRUE(readiness.is_ready());
}

TEST(ReadinessTest, ListenersHearChangesOnly) {
  Readiness readiness;
  std::vector<bool> heard;
  readiness.Listen([&heard](bool ready) { heard.push_back(ready); });
  readiness.Set("store");
  readiness.Set("draining");
  readiness.Clear("store");
  readiness.Clear("draining");
  readiness.Clear("draining");
  EXPECT_THAT(heard, ElementsAre(false, true));
}

TEST(ReadinessTest, ChangesOfManyThreadsAreHeardInOrder) {
  Readiness readiness;
  std::vector<bool> heard;
  readiness.Listen([&heard](bool ready) { heard.push_back(ready); });
  std::vector<std::thread> threads;
  for (const char* reason : {"a", "b", "c"}) {
    threads.emplace_back([&readiness, reason] {
      for (int k = 0; k < 1000; ++k) {
        readiness.Set(reason);
        readiness.Clear(reason);
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_TRUE(readiness.is_ready());
  ASSERT_FALSE(heard.empty());
  for (size_t k = 0; k < heard.size(); ++k) ASSERT_EQ(heard[k], k % 2 == 1) << k;
}

}  // namespace
}  // namespace cagefit::server
