#include "server/session/memory_account.h"

#include <gtest/gtest.h>

#include <thread>
#include <utility>
#include <vector>

#include "server/session/error_detail.h"

namespace cagefit::server {
namespace {

TEST(MemoryAccountTest, GivesUpToItsLimitAndNamesIt) {
  MemoryAccount account("memory", 100);
  EXPECT_EQ(account.Take(60), absl::OkStatus());
  const absl::Status refused = account.Take(41);
  EXPECT_TRUE(absl::IsResourceExhausted(refused)) << refused;
  EXPECT_EQ(DetailOf(refused)->value, "101");
  EXPECT_EQ(DetailOf(refused)->limit, "100");
  EXPECT_EQ(account.taken(), 60);
  EXPECT_EQ(account.Take(40), absl::OkStatus());
}

TEST(MemoryAccountTest, TellsWhatWasTakenFromItOrFromItsChildren) {
  std::vector<int64_t> told;
  MemoryAccount account("memory", 100, [&told](int64_t bytes) { told.push_back(bytes); });
  MemoryAccount child("part", 50, &account);
  EXPECT_EQ(account.Take(60), absl::OkStatus());
  EXPECT_EQ(child.Take(30), absl::OkStatus());
  EXPECT_FALSE(child.Take(30).ok());  // beyond its own limit
  EXPECT_FALSE(child.Take(11).ok());  // beyond its parent's
  EXPECT_EQ(told, std::vector<int64_t>({60, 30}));
}

TEST(MemoryReservationTest, GivesBackWhatItGrewTo) {
  MemoryAccount account("memory", 100);
  {
    MemoryReservation reservation(&account);
    EXPECT_EQ(reservation.Grow(30), absl::OkStatus());
    EXPECT_EQ(reservation.Grow(30), absl::OkStatus());
    EXPECT_FALSE(reservation.Grow(50).ok());
    EXPECT_EQ(account.taken(), 60);
  }
  EXPECT_EQ(account.taken(), 0);
}

TEST(MemoryReservationTest, MovesWithItsOwner) {
  MemoryAccount account("memory", 100);
  MemoryReservation a(&account), b(&account);
  ASSERT_TRUE(a.Grow(30).ok());
  ASSERT_TRUE(b.Grow(40).ok());
  {
    const MemoryReservation moved(std::move(a));
    EXPECT_EQ(account.taken(), 70);
  }
  EXPECT_EQ(account.taken(), 40);
  b = MemoryReservation(&account);
  EXPECT_EQ(account.taken(), 0);
}

TEST(MemoryAccountTest, StaysWithinItsLimitUnderManyThreads) {
  MemoryAccount account("memory", 1000);
  std::vector<std::thread> threads;
  for (int t = 0; t < 4; ++t) {
    threads.emplace_back([&account] {
      for (int k = 0; k < 2000; ++k) {
        MemoryReservation reservation(&account);
        if (!reservation.Grow(300).ok()) continue;
        EXPECT_LE(account.taken(), 1000 + 3 * 300);  // three more may be about to be refused
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(account.taken(), 0);
}

TEST(MemoryAccountTest, TakesFromItsParentToo) {
  MemoryAccount parent("memory of the server", 100);
  MemoryAccount a("a", 80, &parent), b("b", 80, &parent);
  EXPECT_EQ(a.Take(70), absl::OkStatus());
  const absl::Status refused = b.Take(40);
  EXPECT_EQ(DetailOf(refused)->field, "memory of the server");
  EXPECT_EQ(DetailOf(refused)->value, "110");
  EXPECT_EQ(b.taken(), 0);
  EXPECT_EQ(parent.taken(), 70);
  EXPECT_EQ(b.Take(30), absl::OkStatus());
  a.Give(70);
  EXPECT_EQ(parent.taken(), 30);
}

TEST(MemoryAccountTest, ARefusalSaysWhenToTryAgainUnlessThatIsInVain) {
  MemoryAccount account("memory", 100);
  ASSERT_TRUE(account.Take(60).ok());
  EXPECT_GT(DetailOf(account.Take(50))->retry_after, absl::ZeroDuration());
  EXPECT_EQ(DetailOf(account.Take(101))->retry_after, absl::ZeroDuration());
}

TEST(MemoryReservationTest, ShrinksAndNeverGrowsByThat) {
  MemoryAccount account("memory", 100);
  MemoryReservation reservation(&account);
  ASSERT_TRUE(reservation.Grow(60).ok());
  reservation.ShrinkTo(20);
  EXPECT_EQ(account.taken(), 20);
  reservation.ShrinkTo(50);
  EXPECT_EQ(account.taken(), 20);
}

}  // namespace
}  // namespace cagefit::server
