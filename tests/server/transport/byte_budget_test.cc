#include "server/transport/byte_budget.h"

#include <gtest/gtest.h>

#include <thread>
#include <utility>
#include <vector>

namespace cagefit::server {
namespace {

TEST(ByteBudgetTest, GivesUpToItsLimitAndNamesIt) {
  ByteBudget budget(100);
  EXPECT_EQ(budget.Take(60), absl::OkStatus());
  const absl::Status refused = budget.Take(41);
  EXPECT_TRUE(absl::IsResourceExhausted(refused)) << refused;
  EXPECT_EQ(DetailOf(refused)->value, "101");
  EXPECT_EQ(DetailOf(refused)->limit, "100");
  EXPECT_EQ(budget.taken(), 60);
  EXPECT_EQ(budget.Take(40), absl::OkStatus());
}

TEST(ByteReservationTest, GivesBackWhatItGrewTo) {
  ByteBudget budget(100);
  {
    ByteReservation reservation(&budget);
    EXPECT_EQ(reservation.Grow(30), absl::OkStatus());
    EXPECT_EQ(reservation.Grow(30), absl::OkStatus());
    EXPECT_FALSE(reservation.Grow(50).ok());
    EXPECT_EQ(budget.taken(), 60);
  }
  EXPECT_EQ(budget.taken(), 0);
}

TEST(ByteReservationTest, MovesWithItsOwner) {
  ByteBudget budget(100);
  ByteReservation a(&budget), b(&budget);
  ASSERT_TRUE(a.Grow(30).ok());
  ASSERT_TRUE(b.Grow(40).ok());
  {
    const ByteReservation moved(std::move(a));
    EXPECT_EQ(budget.taken(), 70);
  }
  EXPECT_EQ(budget.taken(), 40);
  b = ByteReservation(&budget);
  EXPECT_EQ(budget.taken(), 0);
}

TEST(ByteBudgetTest, StaysWithinItsLimitUnderManyThreads) {
  ByteBudget budget(1000);
  std::vector<std::thread> threads;
  for (int t = 0; t < 4; ++t) {
    threads.emplace_back([&budget] {
      for (int k = 0; k < 2000; ++k) {
        ByteReservation reservation(&budget);
        if (!reservation.Grow(300).ok()) continue;
        EXPECT_LE(budget.taken(), 1000 + 3 * 300);  // three more may be about to be refused
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(budget.taken(), 0);
}

}  // namespace
}  // namespace cagefit::server
