#include "server/session/worker_pool.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <future>
#include <memory>
#include <numeric>
#include <optional>

#include "absl/strings/str_cat.h"
#include "server/session/error_detail.h"

namespace cagefit::server {
namespace {

using ::testing::ElementsAre;

// A task that holds its worker until it is let go.
class Gate {
 public:
  // Returns once a worker is in it.
  void HoldOneWorkerOf(WorkerPool* pool) {
    auto open = std::make_shared<std::shared_future<void>>(open_.get_future());
    ASSERT_TRUE(pool->Run("gate",
                          [this, open] {
                            entered_.set_value();
                            open->wait();
                          })
                    .ok());
    entered_.get_future().wait();
  }
  void Open() { open_.set_value(); }

 private:
  std::promise<void> entered_, open_;
};

TEST(WorkerPoolTest, RunsTasksOfOneKeyInOrderAndOneAtATime) {
  std::vector<int> order;  // without a lock: the pool has to keep the tasks apart
  {
    WorkerPool pool("tasks", 4, 10'000);
    for (int k = 0; k < 2000; ++k) {
      ASSERT_TRUE(pool.Run("key", [&order, k] { order.push_back(k); }).ok());
    }
  }
  std::vector<int> expected(2000);
  std::iota(expected.begin(), expected.end(), 0);
  EXPECT_EQ(order, expected);
}

TEST(WorkerPoolTest, DifferentKeysRunAtTheSameTime) {
  WorkerPool pool("tasks", 2, 100);
  std::promise<void> a_runs, b_runs, both;
  ASSERT_TRUE(pool.Run("a",
                       [&] {
                         a_runs.set_value();
                         b_runs.get_future().wait();
                         both.set_value();
                       })
                  .ok());
  ASSERT_TRUE(pool.Run("b",
                       [&] {
                         a_runs.get_future().wait();
                         b_runs.set_value();
                       })
                  .ok());
  EXPECT_EQ(both.get_future().wait_for(std::chrono::seconds(30)), std::future_status::ready);
}

TEST(WorkerPoolTest, ABusyKeyDoesNotStarveTheOthers) {
  std::vector<std::string> order;
  {
    WorkerPool pool("tasks", 1, 100, 0, [] { return 0.0; });
    Gate gate;
    gate.HoldOneWorkerOf(&pool);
    for (const char* key : {"busy", "busy", "busy", "a", "a", "b"}) {
      ASSERT_TRUE(pool.Run(key, [&order, key] { order.push_back(key); }).ok());
    }
    gate.Open();
  }
  EXPECT_THAT(order, ElementsAre("busy", "a", "b", "busy", "a", "busy"));
}

TEST(WorkerPoolTest, RefusesMoreThanMayWait) {
  std::atomic<int> ran{0};
  {
    WorkerPool pool("tasks", 1, 2);
    Gate gate;
    gate.HoldOneWorkerOf(&pool);
    EXPECT_TRUE(pool.Run("a", [&ran] { ++ran; }).ok());
    EXPECT_TRUE(pool.Run("b", [&ran] { ++ran; }).ok());
    const absl::Status refused = pool.Run("c", [&ran] { ran += 100; });
    EXPECT_TRUE(absl::IsResourceExhausted(refused)) << refused;
    const auto detail = DetailOf(refused);
    ASSERT_TRUE(detail.has_value());
    EXPECT_EQ(detail->field, "queued tasks");
    EXPECT_EQ(detail->value, "3");
    EXPECT_EQ(detail->limit, "2");
    gate.Open();
  }
  EXPECT_EQ(ran, 2);
}

TEST(WorkerPoolTest, TakesTasksAgainOnceOthersHaveRun) {
  WorkerPool pool("tasks", 1, 1);
  for (int k = 0; k < 100; ++k) {
    std::promise<void> ran;
    ASSERT_TRUE(pool.Run("key", [&ran] { ran.set_value(); }).ok());
    ran.get_future().wait();
  }
}

TEST(WorkerPoolTest, RunsWhatIsQueuedBeforeItEnds) {
  for (const int threads : {1, 3}) {
    std::atomic<int> ran{0};
    {
      WorkerPool pool("tasks", threads, 1000);
      Gate gate;
      gate.HoldOneWorkerOf(&pool);
      for (int k = 0; k < 500; ++k) {
        ASSERT_TRUE(pool.Run(absl::StrCat(k % 7), [&ran] { ++ran; }).ok());
      }
      gate.Open();
    }
    EXPECT_EQ(ran, 500);
  }
}

TEST(WorkerPoolTest, ATaskMayQueueAnotherWhileThePoolEnds) {
  std::atomic<int> ran{0};
  {
    WorkerPool pool("tasks", 2, 100);
    ASSERT_TRUE(pool.Run("a",
                         [&] {
                           EXPECT_TRUE(pool.Run("b", [&ran] { ++ran; }).ok());
                           ++ran;
                         })
                    .ok());
  }
  EXPECT_EQ(ran, 2);
}

TEST(WorkerPoolTest, WhatATaskHoldsGoesBeforeTheNextOneOfItsKeyStarts) {
  auto held = std::make_shared<int>(0);
  const std::weak_ptr<int> watch = held;
  std::optional<bool> gone;
  {
    WorkerPool pool("tasks", 2, 100);
    ASSERT_TRUE(pool.Run("key", [held = std::move(held)] { ++*held; }).ok());
    ASSERT_TRUE(pool.Run("key", [&] { gone = watch.expired(); }).ok());
  }
  EXPECT_EQ(gone, true);
}

// A clock that tasks move.
class Time {
 public:
  std::function<double()> Clock() {
    return [this] { return ms_.load(); };
  }
  void Pass(double ms) { ms_ = ms_ + ms; }

 private:
  std::atomic<double> ms_{0};
};

TEST(WorkerPoolTest, KeysGetTheSameTimeWhateverTheirTasksTake) {
  Time time;
  std::map<std::string, double> used;
  std::map<std::string, double> at_half_time;
  {
    WorkerPool pool("tasks", 1, 10'000, 0, time.Clock());
    Gate gate;
    gate.HoldOneWorkerOf(&pool);
    const auto add = [&](const std::string& key, int tasks, double ms) {
      for (int k = 0; k < tasks; ++k) {
        ASSERT_TRUE(pool.Run(key,
                             [&used, &at_half_time, &time, key, ms] {
                               used[key] += ms;
                               time.Pass(ms);
                               if (key == "large" && used[key] == 2000) at_half_time = used;
                             })
                        .ok());
      }
    };
    add("large", 4, 1000);
    add("a", 200, 20);
    add("b", 200, 20);
    gate.Open();
  }
  // When a large task begins, the others have had what it will have used.
  EXPECT_NEAR(at_half_time["a"], 2000, 40);
  EXPECT_NEAR(at_half_time["b"], 2000, 40);
}

TEST(WorkerPoolTest, ALongTaskGivesWayToAKeyThatHasUsedLess) {
  Time time;
  std::vector<std::string> order;
  std::promise<void> begun;
  {
    WorkerPool pool("tasks", 1, 100, 1, time.Clock());
    std::promise<void> waiting;
    ASSERT_TRUE(pool.Run("large",
                         [&] {
                           begun.set_value();
                           waiting.get_future().wait();
                           time.Pass(WorkerPool::kSliceMs - 1);
                           EXPECT_FALSE(pool.IsOvertaken());
                           pool.GiveWay();  // too early
                           order.push_back("large begins");
                           time.Pass(2);
                           EXPECT_TRUE(pool.IsOvertaken());
                           pool.GiveWay();
                           EXPECT_FALSE(pool.IsOvertaken());
                           order.push_back("large ends");
                         })
                    .ok());
    begun.get_future().wait();
    ASSERT_TRUE(pool.Run("small", [&order] { order.push_back("small"); }).ok());
    waiting.set_value();
  }
  EXPECT_THAT(order, ElementsAre("large begins", "small", "large ends"));
}

TEST(WorkerPoolTest, ATaskGoesOnWhereNobodyWaitsOrNoMoreMayPause) {
  Time time;
  std::vector<std::string> order;
  {
    WorkerPool pool("tasks", 1, 100, 0, time.Clock());
    Gate gate;
    gate.HoldOneWorkerOf(&pool);
    ASSERT_TRUE(pool.Run("large",
                         [&] {
                           time.Pass(1000);
                           EXPECT_FALSE(pool.IsOvertaken());
                           pool.GiveWay();
                           order.push_back("large");
                         })
                    .ok());
    ASSERT_TRUE(pool.Run("small", [&order] { order.push_back("small"); }).ok());
    gate.Open();
  }
  EXPECT_THAT(order, ElementsAre("large", "small"));
}

TEST(WorkerPoolTest, OtherThreadsNeverGiveWay) {
  WorkerPool pool("tasks", 1, 100, 1, [] { return 1e9; });
  pool.GiveWay();
}

// Two large fits on two workers hold up small ones for a slice, not for as long as they take.
TEST(WorkerPoolTest, AllWorkersMayBeGivenWayTo) {
  std::atomic<bool> small_ran{false};
  {
    WorkerPool pool("tasks", 2, 100, 2);
    std::promise<void> begun[2];
    for (int k = 0; k < 2; ++k) {
      ASSERT_TRUE(pool.Run(absl::StrCat("large", k),
                           [&, k] {
                             begun[k].set_value();
                             while (!small_ran) {
                               pool.GiveWay();
                               std::this_thread::yield();
                             }
                           })
                      .ok());
    }
    for (auto& promise : begun) promise.get_future().wait();
    ASSERT_TRUE(pool.Run("small", [&small_ran] { small_ran = true; }).ok());
  }
  EXPECT_TRUE(small_ran);
}

TEST(WorkerPoolTest, ARefusalSaysWhenToTryAgain) {
  WorkerPool pool("tasks", 1, 0);
  const auto detail = DetailOf(pool.Run("key", [] {}));
  ASSERT_TRUE(detail.has_value());
  EXPECT_GT(detail->retry_after, absl::ZeroDuration());
  EXPECT_LE(detail->retry_after, absl::Seconds(30));
}

TEST(WorkerPoolTest, BatchWorkWaitsForLiveWork) {
  Time time;
  std::vector<std::string> order;
  {
    WorkerPool pool("tasks", 1, 100, 0, time.Clock());
    Gate gate;
    gate.HoldOneWorkerOf(&pool);
    const auto add = [&](const char* key, Priority priority) {
      ASSERT_TRUE(pool.Run(
                          key,
                          [&order, &time, key] {
                            order.push_back(key);
                            time.Pass(10);
                          },
                          priority)
                      .ok());
    };
    for (int k = 0; k < 3; ++k) add("batch", Priority::kBatch);
    for (int k = 0; k < 3; ++k) add("live", Priority::kLive);
    gate.Open();
  }
  // One turn is the share that batch work has in any case.
  EXPECT_THAT(order, ElementsAre("live", "batch", "live", "live", "batch", "batch"));
}

TEST(WorkerPoolTest, ManyKeysThatGiveWayAllComeToTheirEnd) {
  std::atomic<int> ran{0};
  {
    WorkerPool pool("tasks", 2, 1000, 3);
    for (int k = 0; k < 100; ++k) {
      ASSERT_TRUE(pool.Run(
                          absl::StrCat(k % 20),
                          [&ran, &pool, k] {
                            const double end = SteadyMilliseconds() + 2 + k % 50;
                            while (SteadyMilliseconds() < end) pool.GiveWay();
                            ++ran;
                          },
                          k % 3 == 0 ? Priority::kBatch : Priority::kLive)
                      .ok());
    }
  }
  EXPECT_EQ(ran, 100);
}

TEST(WorkerPoolTest, TellsHowManyTasksWait) {
  WorkerPool pool("tasks", 1, 100);
  EXPECT_EQ(pool.queued(), 0);
  Gate gate;
  gate.HoldOneWorkerOf(&pool);
  EXPECT_EQ(pool.queued(), 0);  // it runs
  for (const char* key : {"a", "a", "b"}) ASSERT_TRUE(pool.Run(key, [] {}).ok());
  EXPECT_EQ(pool.queued(), 3);
  gate.Open();
}

TEST(WorkerPoolTest, TheBusyClockStandsStillWhileATaskHasGivenWay) {
  double busy = 0, passed = 0;
  {
    WorkerPool pool("tasks", 1, 100, 1);
    std::promise<void> begun, waiting;
    ASSERT_TRUE(pool.Run("large",
                         [&] {
                           begun.set_value();
                           waiting.get_future().wait();
                           const double start = SteadyMilliseconds(),
                                        busy_start = BusyMilliseconds();
                           for (double end = start + 2 * WorkerPool::kSliceMs;
                                SteadyMilliseconds() < end;) {
                             pool.GiveWay();
                           }
                           busy = BusyMilliseconds() - busy_start;
                           passed = SteadyMilliseconds() - start;
                         })
                    .ok());
    begun.get_future().wait();
    ASSERT_TRUE(pool.Run("small",
                         [] {
                           for (double end = SteadyMilliseconds() + 200;
                                SteadyMilliseconds() < end;) {
                           }
                         })
                    .ok());
    waiting.set_value();
  }
  EXPECT_GE(passed - busy, 199);
}

}  // namespace
}  // namespace cagefit::server
