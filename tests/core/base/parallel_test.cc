#include "core/base/parallel.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <vector>

namespace cagefit {
namespace {

// Numbers whose sum depends on the order of addition.
double UnevenSum(int64_t begin, int64_t end) {
  double sum = 0;
  for (int64_t i = begin; i < end; ++i) sum += std::sin(0.1 * i) * std::pow(10.0, i % 13);
  return sum;
}

TEST(ParallelForTest, VisitsEveryIndexOnce) {
  for (const int64_t count : {0, 1, 7, 8, 9, 1000}) {
    std::vector<int> visits(count, 0);
    ParallelFor(count, 8, [&](int64_t begin, int64_t end) {
      EXPECT_EQ(begin % 8, 0);
      for (int64_t i = begin; i < end; ++i) ++visits[i];
    });
    EXPECT_EQ(visits, std::vector<int>(count, 1)) << count;
  }
}

TEST(ParallelSumTest, IsTheSameToTheBitForAnyNumberOfThreads) {
  std::vector<double> sums;
  for (const int threads : {1, 2, 4}) {
    tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    sums.push_back(ParallelSum(100003, 64, UnevenSum));
  }
  EXPECT_EQ(sums[0], sums[1]);
  EXPECT_EQ(sums[0], sums[2]);
}

TEST(ParallelSumTest, AddsChunksInOrder) {
  double expected = 0;
  for (int64_t begin = 0; begin < 1000; begin += 64) {
    expected += UnevenSum(begin, std::min<int64_t>(1000, begin + 64));
  }
  EXPECT_EQ(ParallelSum(1000, 64, UnevenSum), expected);
}

TEST(ParallelSumTest, OfNothingIsZero) {
  EXPECT_EQ(ParallelSum(0, 64, [](int64_t, int64_t) { return 1.0; }), 0.0);
}

}  // namespace
}  // namespace cagefit
