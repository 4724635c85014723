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
    WorkerPool pool("tasks", 1, 100);
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

}  // namespace
}  // namespace cagefit::server
