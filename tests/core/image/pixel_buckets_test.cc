#include "core/image/pixel_buckets.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/base/random.h"

namespace cagefit {
namespace {

TEST(PixelBucketsTest, EveryPointLiesInItsCell) {
  Random random(1);
  std::vector<float> u(2000), v(2000);
  for (int i = 0; i < 2000; ++i) {
    u[i] = static_cast<float>(random.Uniform(-20, 30));
    v[i] = static_cast<float>(random.Uniform(-20, 30));
  }
  const PixelWindow window{-7, 3, 21, 12};
  for (const int per_pixel : {1, 2, 3}) {
    PixelBuckets buckets;
    buckets.Build(u, v, window, per_pixel);
    ASSERT_EQ(buckets.width(), per_pixel * 20 + 1);
    ASSERT_EQ(buckets.height(), per_pixel * 11 + 1);
    EXPECT_EQ(buckets.begin(0, 0), 0);
    int count = 0;
    for (int y = 0; y < buckets.height(); ++y) {
      for (int x = 0; x < buckets.width(); ++x) {
        for (int32_t k = buckets.begin(x, y); k < buckets.begin(x + 1, y); ++k, ++count) {
          const int32_t i = buckets.source(k);
          ASSERT_LE(std::abs(per_pixel * (u[i] - -7.0f) - static_cast<float>(x)), 0.5001f);
          ASSERT_LE(std::abs(per_pixel * (v[i] - 3.0f) - static_cast<float>(y)), 0.5001f);
          ASSERT_TRUE(k == buckets.begin(x, y) || i > buckets.source(k - 1));
        }
      }
    }
    EXPECT_EQ(count, buckets.size());
    const float half = 0.5f / static_cast<float>(per_pixel);
    int within = 0;
    for (int i = 0; i < 2000; ++i) {
      within += u[i] >= -7 - half && u[i] < 13 + half && v[i] >= 3 - half && v[i] < 14 + half;
    }
    EXPECT_EQ(buckets.size(), within);
  }
}

TEST(PixelBucketsTest, LeavesOutWhatIsNoNumber) {
  const float inf = std::numeric_limits<float>::infinity();
  const std::vector<float> u = {1, std::nanf(""), 1, inf, 1, 2},
                           v = {1, 1, -inf, 1, std::nanf(""), 2};
  PixelBuckets buckets;
  buckets.Build(u, v, {0, 0, 4, 4}, 1);
  ASSERT_EQ(buckets.size(), 2);
  EXPECT_EQ(buckets.source(0), 0);
  EXPECT_EQ(buckets.source(1), 5);
}

}  // namespace
}  // namespace cagefit
