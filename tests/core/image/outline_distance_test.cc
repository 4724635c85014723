#include "core/image/outline_distance.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/random.h"

namespace cagefit {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

double DistanceToSegment(const Eigen::Vector2d& p, const Eigen::Vector2d& a,
                         const Eigen::Vector2d& b) {
  const Eigen::Vector2d d = b - a;
  const double t = d.squaredNorm() > 0 ? std::clamp((p - a).dot(d) / d.squaredNorm(), 0.0, 1.0) : 0;
  return (p - a - t * d).norm();
}

// Segments of all kinds: short, crossing the image, outside it, of zero length, axis-parallel.
Outline RandomSegments(int count, uint64_t seed) {
  Random random(seed);
  Outline outline;
  outline.points.resize(2, 2 * count);
  outline.segments.resize(2, count);
  for (int s = 0; s < count; ++s) {
    const double size = std::pow(10.0, random.Uniform(-2, 2.5));
    const Eigen::Vector2d a(random.Uniform(-30, 100), random.Uniform(-30, 80));
    Eigen::Vector2d d(random.Uniform(-size, size), random.Uniform(-size, size));
    if (s % 7 == 0) d.setZero();
    if (s % 7 == 1) d[0] = 0;
    if (s % 7 == 2) d[1] = 0;
    outline.points.col(2 * s) = a;
    outline.points.col(2 * s + 1) = a + d;
    outline.segments.col(s) << 2 * s, 2 * s + 1;
  }
  return outline;
}

Outline OneSegment(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  Outline outline;
  outline.points.resize(2, 2);
  outline.points << a, b;
  outline.segments.resize(2, 1);
  outline.segments << 0, 1;
  return outline;
}

TEST(OutlineDistanceTest, IsThatOfBruteForce) {
  for (const double reach : {0.6, 4.0, 200.0}) {
    const Outline outline = RandomSegments(25, 7);
    OutlineDistance out;
    MeasureOutline(outline, 71, 53, reach, &out);

    int within = 0;
    for (int y = 0; y < 53; ++y) {
      for (int x = 0; x < 71; ++x) {
        double least = kInfinity;
        for (int s = 0; s < 25; ++s) {
          least = std::min(least, DistanceToSegment({x, y}, outline.points.col(2 * s),
                                                    outline.points.col(2 * s + 1)));
        }
        const int p = y * 71 + x;
        if (least > reach) {
          ASSERT_EQ(out.segment[p], -1) << x << " " << y << " reach " << reach;
          ASSERT_EQ(out.distance[p], kInfinity);
          continue;
        }
        ++within;
        const int s = out.segment[p];
        ASSERT_GE(s, 0) << x << " " << y << " reach " << reach;
        ASSERT_NEAR(out.distance[p], least, 1e-9);
        ASSERT_NEAR(
            DistanceToSegment({x, y}, outline.points.col(2 * s), outline.points.col(2 * s + 1)),
            least, 1e-9);
      }
    }
    EXPECT_GT(within, 50);
  }
}

TEST(OutlineDistanceTest, TiesGoToTheLowerIndex) {
  // A corner at (20, 20): the pixels beyond it are nearest to the point that both segments share.
  Outline outline;
  outline.points.resize(2, 3);
  outline.points << 20.25, 3.125, 20.25, 20.25, 20.25, 3.3;
  for (const bool swapped : {false, true}) {
    outline.segments.resize(2, 2);
    if (swapped) {
      outline.segments << 0, 1, 2, 0;
    } else {
      outline.segments << 1, 0, 0, 2;
    }
    OutlineDistance out;
    MeasureOutline(outline, 32, 32, 9, &out);
    for (int y = 21; y < 26; ++y) {
      for (int x = 21; x < 26; ++x) EXPECT_EQ(out.segment[y * 32 + x], 0) << x << " " << y;
    }
  }
}

TEST(OutlineDistanceTest, IsTheSameToTheBitForAnyNumberOfThreads) {
  const Outline outline = RandomSegments(400, 3);
  OutlineDistance one, many;
  {
    tbb::global_control serial(tbb::global_control::max_allowed_parallelism, 1);
    MeasureOutline(outline, 200, 150, 5, &one);
  }
  MeasureOutline(outline, 200, 150, 5, &many);
  EXPECT_EQ(one.distance, many.distance);
  EXPECT_EQ(one.segment, many.segment);
}

TEST(OutlineDistanceTest, ReadsSegmentsThatAreHugeOrNotFinite) {
  OutlineDistance out;
  MeasureOutline(OneSegment({-1e9, 10.5}, {1e9, 10.5}), 64, 64, 3, &out);
  for (int x = 0; x < 64; ++x) {
    EXPECT_NEAR(out.distance[10 * 64 + x], 0.5, 1e-6);
    EXPECT_NEAR(out.distance[13 * 64 + x], 2.5, 1e-6);
    EXPECT_EQ(out.segment[14 * 64 + x], -1);
  }
  for (const double bad : {kInfinity, -kInfinity, std::nan("")}) {
    MeasureOutline(OneSegment({5, 5}, {bad, 20}), 64, 64, 3, &out);
    EXPECT_EQ(*std::max_element(out.segment.begin(), out.segment.end()), -1) << bad;
  }
  MeasureOutline(OneSegment({-1e200, -1e200}, {1e200, 1e200}), 64, 64, 3, &out);
}

TEST(OutlineDistanceTest, FindsNothingForAnEmptyOutline) {
  OutlineDistance out;
  MeasureOutline(RandomSegments(5, 1), 20, 10, 5, &out);
  MeasureOutline(Outline(), 10, 20, 5, &out);
  ASSERT_EQ(out.distance.size(), 200u);
  EXPECT_EQ(*std::max_element(out.segment.begin(), out.segment.end()), -1);
}

TEST(OutlineDistanceTest, KeepsTheCapacityOfItsBuffers) {
  OutlineDistance out;
  MeasureOutline(RandomSegments(50, 1), 64, 64, 5, &out);
  const double* const distance = out.distance.data();
  const int32_t* const segments = out.strip_segments.data();
  MeasureOutline(RandomSegments(50, 1), 64, 64, 4, &out);
  EXPECT_EQ(out.distance.data(), distance);
  EXPECT_EQ(out.strip_segments.data(), segments);
}

}  // namespace
}  // namespace cagefit
