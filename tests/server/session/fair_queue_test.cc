#include "server/session/fair_queue.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <vector>

#include "absl/strings/str_cat.h"

namespace cagefit::server {
namespace {

using ::testing::ElementsAre;

// Keys that always have a next task, on one worker.
class Simulation {
 public:
  void Add(const std::string& key, double task_ms, Priority priority = Priority::kLive) {
    keys_[key] = {task_ms, priority, 0};
    queue_.Add(key, priority);
  }
  void Run(double ms) {
    for (double time = 0; time < ms;) {
      const std::string key = queue_.Take();
      Key& used = keys_.at(key);
      queue_.Charge(key, used.task_ms);
      queue_.Expect(key, used.task_ms);
      queue_.Release(key);
      queue_.Add(key, used.priority);
      used.ms += used.task_ms;
      time += used.task_ms;
    }
  }
  double UsedBy(const std::string& key) const { return keys_.at(key).ms; }
  void Forget() {
    for (auto& [name, key] : keys_) key.ms = 0;
  }

 private:
  struct Key {
    double task_ms = 0;
    Priority priority = Priority::kLive;
    double ms = 0;
  };
  FairQueue queue_;
  std::map<std::string, Key> keys_;
};

std::vector<std::string> TakeAll(FairQueue* queue) {
  std::vector<std::string> keys;
  while (!queue->empty()) keys.push_back(queue->Take());
  return keys;
}

TEST(FairQueueTest, ServesEqualsInTheOrderOfTheirArrival) {
  FairQueue queue;
  for (const char* key : {"c", "a", "b"}) queue.Add(key, Priority::kLive);
  EXPECT_THAT(TakeAll(&queue), ElementsAre("c", "a", "b"));
}

TEST(FairQueueTest, ServesTheOneThatHasUsedLeast) {
  FairQueue queue;
  double ms = 30;
  for (const char* key : {"a", "b", "c"}) {
    queue.Add(key, Priority::kLive);
    queue.Take();
    queue.Charge(key, ms);
    ms -= 10;
    queue.Release(key);
  }
  for (const char* key : {"a", "b", "c"}) queue.Add(key, Priority::kLive);
  EXPECT_THAT(TakeAll(&queue), ElementsAre("c", "b", "a"));
}

TEST(FairQueueTest, GivesEveryKeyTheSameTimeWhateverItsTasksTake) {
  Simulation simulation;
  simulation.Add("large", 2000);
  for (int k = 0; k < 40; ++k) simulation.Add(absl::StrCat("small", k), 15 + k % 7);
  simulation.Run(300'000);
  for (int k = 0; k < 40; ++k) {
    EXPECT_NEAR(simulation.UsedBy(absl::StrCat("small", k)), 300'000 / 41, 2000) << k;
  }
  EXPECT_NEAR(simulation.UsedBy("large"), 300'000 / 41, 2000);
}

TEST(FairQueueTest, AKeyThatPausedDoesNotCatchUp) {
  Simulation simulation;
  simulation.Add("old", 10);
  simulation.Run(100'000);
  simulation.Add("new", 10);
  simulation.Forget();
  simulation.Run(1000);
  EXPECT_NEAR(simulation.UsedBy("new"), 500, 20);
}

TEST(FairQueueTest, AKeyThatWasAwayForAMomentStillOwesWhatItUsed) {
  FairQueue queue;
  queue.Add("large", Priority::kLive);
  queue.Take();
  queue.Add("small", Priority::kLive);
  queue.Charge("large", 1000);
  queue.Release("large");
  EXPECT_EQ(queue.Take(), "small");
  queue.Charge("small", 10);
  queue.Add("large", Priority::kLive);
  EXPECT_FALSE(queue.IsOvertaken("small"));
  queue.Charge("small", 980);
  EXPECT_FALSE(queue.IsOvertaken("small"));
  queue.Charge("small", 20);
  EXPECT_TRUE(queue.IsOvertaken("small"));
}

TEST(FairQueueTest, NoKeyOwesMoreThanTheMost) {
  FairQueue queue;
  queue.Add("huge", Priority::kLive);
  queue.Take();
  queue.Charge("huge", 1e9);
  queue.Release("huge");
  queue.Add("huge", Priority::kLive);
  queue.Add("small", Priority::kLive);
  double waited = 0;
  for (; queue.Take() == "small"; waited += 100) {
    queue.Charge("small", 100);
    queue.Release("small");
    queue.Add("small", Priority::kLive);
  }
  EXPECT_NEAR(waited, FairQueue::kMostDebtMs, 100);
}

TEST(FairQueueTest, BatchWorkGetsItsShareWhileLiveWorkWaits) {
  Simulation simulation;
  for (int k = 0; k < 10; ++k) simulation.Add(absl::StrCat("batch", k), 100, Priority::kBatch);
  simulation.Add("live", 20);
  simulation.Run(100'000);
  EXPECT_NEAR(simulation.UsedBy("live"), 100'000 * (1 - FairQueue::kBatchShare), 1000);
  for (int k = 0; k < 10; ++k) {
    EXPECT_NEAR(simulation.UsedBy(absl::StrCat("batch", k)), 10'000 * FairQueue::kBatchShare, 150);
  }
}

TEST(FairQueueTest, BatchWorkGetsAllThatLiveWorkLeavesAndOwesLittleForIt) {
  FairQueue queue;
  queue.Add("live", Priority::kLive);
  queue.Take();  // and works on, on another worker
  queue.Add("batch", Priority::kBatch);
  for (int k = 0; k < 1000; ++k) {
    ASSERT_EQ(queue.Take(), "batch");
    queue.Charge("batch", 1000);
    queue.Release("batch");
    queue.Add("batch", Priority::kBatch);
  }
  queue.Charge("live", 20);
  queue.Release("live");
  queue.Add("live", Priority::kLive);
  double waited = 0;
  for (; queue.Take() == "live"; waited += 100) {
    queue.Charge("live", 100);
    queue.Release("live");
    queue.Add("live", Priority::kLive);
  }
  EXPECT_LE(waited, FairQueue::kMostGroupDebtMs);
}

TEST(FairQueueTest, ALiveKeyOvertakesABatchKeyThatRuns) {
  FairQueue queue;
  queue.Add("batch", Priority::kBatch);
  queue.Take();
  queue.Charge("batch", 30);
  EXPECT_FALSE(queue.IsOvertaken("batch"));
  queue.Add("live", Priority::kLive);
  EXPECT_TRUE(queue.IsOvertaken("batch"));
}

TEST(FairQueueTest, OfEqualsTheOneWithTheShorterTaskIsFirst) {
  FairQueue queue;
  for (const char* key : {"large", "small"}) {
    queue.Add(key, Priority::kLive);
    queue.Take();
    queue.Expect(key, key == std::string("large") ? 2000 : 20);
    queue.Release(key);
  }
  for (const char* key : {"large", "small"}) queue.Add(key, Priority::kLive);
  EXPECT_THAT(TakeAll(&queue), ElementsAre("small", "large"));
}

// Cutting up equal fits would only let all of them end late.
TEST(FairQueueTest, AKeyIsOvertakenByOneThatWillBeDoneSoonerNotByItsEqual) {
  FairQueue queue;
  for (const char* key : {"a", "b", "small"}) {
    queue.Add(key, Priority::kLive);
    queue.Take();
    queue.Expect(key, key == std::string("small") ? 20 : 500);
    queue.Release(key);
  }
  queue.Add("a", Priority::kLive);
  queue.Take();
  queue.Add("b", Priority::kLive);
  queue.Charge("a", 400);
  EXPECT_FALSE(queue.IsOvertaken("a"));
  queue.Add("small", Priority::kLive);
  EXPECT_TRUE(queue.IsOvertaken("a"));
}

TEST(FairQueueTest, ForgetsTheKeysThatOweLeast) {
  FairQueue queue;
  for (int k = 0; k < 20'000; ++k) {
    const std::string key = absl::StrCat(k);
    queue.Add(key, Priority::kLive);
    queue.Take();
    queue.Charge(key, 5);
    queue.Release(key);
  }
  EXPECT_LE(queue.remembered(), 5000u);
}

}  // namespace
}  // namespace cagefit::server
