#include "core/image/point_outline.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include "core/base/random.h"

namespace cagefit {
namespace {

constexpr int kSize = 64;

struct Points {
  std::vector<float> u, v;
  void Add(double x, double y) {
    u.push_back(static_cast<float>(x));
    v.push_back(static_cast<float>(y));
  }
};

// Points 0.5 apart where `inside` holds, from -20 to 84.
Points Filled(const std::function<bool(double, double)>& inside) {
  Points points;
  for (int j = 0; j <= 208; ++j) {
    for (int i = 0; i <= 208; ++i) {
      const double x = -20 + 0.5 * i, y = -20 + 0.5 * j;
      if (inside(x, y)) points.Add(x, y);
    }
  }
  return points;
}

double Length(const Outline& outline) {
  double length = 0;
  for (int s = 0; s < outline.segments.cols(); ++s) {
    length +=
        (outline.points.col(outline.segments(0, s)) - outline.points.col(outline.segments(1, s)))
            .norm();
  }
  return length;
}

int InsideCount(const PointOutline& region) {
  int count = 0;
  for (const float value : region.inside().values) count += value == 1;
  return count;
}

TEST(PointOutlineTest, IsTheClosingByBruteForce) {
  // A point is outside the closing where an empty disk of the radius can be laid over it.
  Random random(2);
  Points points;
  for (int i = 0; i < 150; ++i) points.Add(random.Uniform(14, 50), random.Uniform(14, 50));
  constexpr int kFine = 8, kFineSize = kSize * kFine, kFineRadius = 3 * kFine;
  PointOutline region;
  region.Build(points.u, points.v, kSize, kSize, {3, 3});
  std::vector<double> D(kFineSize * kFineSize, 1e9);
  for (int j = 0; j < kFineSize; ++j) {
    for (int i = 0; i < kFineSize; ++i) {
      double& d = D[j * kFineSize + i];
      for (size_t k = 0; k < points.u.size(); ++k) {
        d = std::min(d, std::hypot(points.u[k] - 1.0 * i / kFine, points.v[k] - 1.0 * j / kFine));
      }
    }
  }
  int compared = 0;
  for (int y = 4; y < kSize - 4; ++y) {
    for (int x = 4; x < kSize - 4; ++x) {
      double farthest = 0;
      for (int j = -kFineRadius; j <= kFineRadius; ++j) {
        for (int i = -kFineRadius; i <= kFineRadius; ++i) {
          if (i * i + j * j > kFineRadius * kFineRadius) continue;
          farthest = std::max(farthest, D[(y * kFine + j) * kFineSize + x * kFine + i]);
        }
      }
      if (std::abs(farthest - 3) < 0.15) continue;  // the search is no finer
      ++compared;
      ASSERT_EQ(*region.inside().at(x, y), farthest < 3 ? 1.0f : 0.0f) << x << " " << y;
    }
  }
  EXPECT_GT(compared, 2000);
}

TEST(PointOutlineTest, GoesThroughTheOutermostPoints) {
  Points points = Filled([](double x, double y) { return std::hypot(x - 31, y - 33) < 15; });
  const size_t filled = points.u.size();
  for (int i = 0; i < 400; ++i) {
    const double angle = 2 * M_PI * i / 400;
    points.Add(31.2 + 17.3 * std::cos(angle), 33.4 + 17.3 * std::sin(angle));
  }
  ASSERT_GT(filled, 2000u);
  PointOutline region;
  region.Build(points.u, points.v, kSize, kSize, {2, 2});
  const Outline& outline = region.outline();
  ASSERT_GT(outline.points.cols(), 100);
  for (int i = 0; i < outline.points.cols(); ++i) {
    const double radius = (outline.points.col(i) - Eigen::Vector2d(31.2, 33.4)).norm();
    ASSERT_NEAR(radius, 17.3, 0.03) << outline.points.col(i).transpose();
  }
  EXPECT_NEAR(Length(outline), 2 * M_PI * 17.3, 0.2);
}

TEST(PointOutlineTest, ClosesSmallHolesAndKeepsLargeOnes) {
  const auto region_with_hole = [](double hole, const ClosingRadii& radii) {
    const Points points = Filled([&](double x, double y) {
      const double d = std::hypot(x - 32, y - 32);
      return d < 25 && d > hole;
    });
    PointOutline region;
    region.Build(points.u, points.v, kSize, kSize, radii);
    return *region.inside().at(32, 32) == 1;
  };
  EXPECT_TRUE(region_with_hole(1.4, {1.5, 4}));
  EXPECT_TRUE(region_with_hole(3.2, {1.5, 4}));  // wider than the radius, not than hole_radius
  EXPECT_FALSE(region_with_hole(3.2, {1.5, 2}));
  EXPECT_FALSE(region_with_hole(5.0, {1.5, 4}));
}

TEST(PointOutlineTest, ALargeHoleIsNotShrunk) {
  const Points points = Filled([](double x, double y) {
    const double d = std::hypot(x - 32, y - 32);
    return d < 25 && d > 10;
  });
  PointOutline region;
  region.Build(points.u, points.v, kSize, kSize, {1.5, 3});
  double sum = 0;
  int count = 0;
  for (int i = 0; i < region.outline().points.cols(); ++i) {
    const double d = (region.outline().points.col(i) - Eigen::Vector2d(32, 32)).norm();
    if (d > 15) continue;
    sum += d;
    ++count;
  }
  ASSERT_GT(count, 50);
  // Points of a grid stay inside their circle by a quarter of a spacing and more.
  EXPECT_GT(sum / count, 10.0);
  EXPECT_LT(sum / count, 10.4);
}

TEST(PointOutlineTest, DoesNotKnowWhereTheImageEnds) {
  // A half plane: its outline is one line, which goes on beyond the image.
  const Points points = Filled([](double x, double y) { return x - 0.3 * y > 20; });
  PointOutline region;
  region.Build(points.u, points.v, kSize, kSize, {1.5, 4});
  for (int i = 0; i < region.outline().points.cols(); ++i) {
    const Eigen::Vector2d p = region.outline().points.col(i);
    if (p.minCoeff() < -1 || p.maxCoeff() > kSize) continue;
    ASSERT_NEAR(p[0] - 0.3 * p[1], 20, 0.6);
  }
  EXPECT_EQ(*region.inside().at(63, 0), 1);
  EXPECT_EQ(*region.inside().at(63, 63), 1);
  EXPECT_EQ(*region.inside().at(0, 0), 0);
}

TEST(PointOutlineTest, OfNoPointsIsEmpty) {
  const float nan = std::nanf(""), inf = std::numeric_limits<float>::infinity();
  PointOutline region;
  region.Build({5, 6}, {5, 6}, kSize, kSize, {2, 2});
  region.Build({nan, inf, 1e6f, -1e30f}, {3, 3, 3, -inf}, kSize, kSize, {2, 4});
  EXPECT_EQ(region.outline().segments.cols(), 0);
  EXPECT_EQ(InsideCount(region), 0);
  region.Build({}, {}, kSize, kSize, {2, 4});
  EXPECT_EQ(InsideCount(region), 0);
}

}  // namespace
}  // namespace cagefit
