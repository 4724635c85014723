#include "core/image/silhouette_image.h"

#include <gtest/gtest.h>

#include <cmath>

namespace cagefit {
namespace {

constexpr int kSize = 64;
constexpr double kHalfSide = kSize / 2.0;
const Eigen::Vector2d kCenter(30.3, 33.8);

Outline Circle(double radius, int count) {
  Outline outline;
  outline.points.resize(2, count);
  outline.segments.resize(2, count);
  for (int i = 0; i < count; ++i) {
    const double angle = 2 * M_PI * i / count;
    outline.points.col(i) = kCenter + radius * Eigen::Vector2d(std::cos(angle), std::sin(angle));
    outline.segments.col(i) << i, (i + 1) % count;
  }
  return outline;
}

Image InsideOfDisk(double radius) {
  Image inside(kSize, kSize);
  for (int y = 0; y < kSize; ++y) {
    for (int x = 0; x < kSize; ++x) {
      *inside.at(x, y) = (Eigen::Vector2d(x, y) - kCenter).norm() < radius ? 1.0f : 0.0f;
    }
  }
  return inside;
}

TEST(SilhouetteImageTest, OfACircleIsTheStepOfItsSignedDistance) {
  const double sigma = 1e-3, radius = 18;
  const double reach = SilhouetteReach(sigma, kHalfSide);
  OutlineDistance distance;
  MeasureOutline(Circle(radius, 2000), kSize, kSize, reach, &distance);

  const Image image = SilhouetteFromOutline(distance, InsideOfDisk(radius), sigma, kHalfSide);

  for (int y = 0; y < kSize; ++y) {
    for (int x = 0; x < kSize; ++x) {
      const double s = (radius - (Eigen::Vector2d(x, y) - kCenter).norm()) / kHalfSide;
      const double expected = 1 / (1 + std::exp(-s * std::abs(s) / sigma));
      ASSERT_NEAR(*image.at(x, y), expected, 2e-5) << x << " " << y;
    }
  }
}

TEST(SilhouetteImageTest, DoesNotDependOnHowTheOutlineIsDivided) {
  OutlineDistance distance;
  MeasureOutline(Circle(18, 200), kSize, kSize, 10, &distance);
  const Image coarse = SilhouetteFromOutline(distance, InsideOfDisk(18), 1e-3, kHalfSide);
  MeasureOutline(Circle(18, 20000), kSize, kSize, 10, &distance);
  const Image fine = SilhouetteFromOutline(distance, InsideOfDisk(18), 1e-3, kHalfSide);
  for (int64_t p = 0; p < fine.pixel_count(); ++p) {
    ASSERT_NEAR(coarse.values[p], fine.values[p], 1e-3);
  }
}

TEST(SilhouetteImageTest, WithoutAnOutlineIsTheInside) {
  OutlineDistance distance;
  MeasureOutline(Outline(), kSize, kSize, 5, &distance);
  const Image inside = InsideOfDisk(10);
  EXPECT_EQ(SilhouetteFromOutline(distance, inside, 1e-4, kHalfSide).values, inside.values);
}

}  // namespace
}  // namespace cagefit
