#include "core/image/marching_squares.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "core/base/random.h"
#include "core/image/outline_distance.h"

namespace cagefit {
namespace {

Image FieldOf(int width, int height, const std::vector<float>& values) {
  Image field(width, height);
  field.values = values;
  return field;
}

Image RandomField(int width, int height, uint64_t seed) {
  Random random(seed);
  Image field(width, height);
  for (float& value : field.values) value = static_cast<float>(random.Uniform());
  return field;
}

TEST(MarchingSquaresTest, OfAPlaneIsTheExactLine) {
  Image field(20, 15);
  for (int y = 0; y < 15; ++y) {
    for (int x = 0; x < 20; ++x) *field.at(x, y) = static_cast<float>(0.3 * x - 0.2 * y);
  }
  Outline outline;
  ExtractOutline(field, 1.37f, &outline);
  ASSERT_GT(outline.segments.cols(), 15);
  for (int i = 0; i < outline.points.cols(); ++i) {
    const Eigen::Vector2d p = outline.points.col(i);
    if (p.minCoeff() < 0 || p[0] > 19 || p[1] > 14) continue;  // the field goes on as a constant
    EXPECT_NEAR(0.3 * p[0] - 0.2 * p[1], 1.37, 1e-5);
  }
}

TEST(MarchingSquaresTest, CurvesEndOnlyOnePixelBeyondTheOutermostCentres) {
  const Image field = RandomField(30, 20, 1);
  Outline outline;
  ExtractOutline(field, 0.5f, &outline);
  std::vector<int> balance(outline.points.cols(),
                           0);  // segments that end here less those that start
  for (int s = 0; s < outline.segments.cols(); ++s) {
    --balance[outline.segments(0, s)];
    ++balance[outline.segments(1, s)];
  }
  for (int i = 0; i < outline.points.cols(); ++i) {
    const Eigen::Vector2d p = outline.points.col(i);
    const bool at_end = p[0] == -1 || p[0] == 30 || p[1] == -1 || p[1] == 20;
    EXPECT_EQ(balance[i] == 0, !at_end) << p.transpose();
  }
}

TEST(MarchingSquaresTest, AFieldThatIsAllInsideHasNoOutline) {
  Outline outline;
  ExtractOutline(Image(8, 6, 1, 1.0f), 0.5f, &outline);
  EXPECT_EQ(outline.segments.cols(), 0);
  EXPECT_EQ(outline.points.cols(), 0);
}

TEST(MarchingSquaresTest, HasTheInsideToTheRightOfEverySegment) {
  // With x right and y down, to the right of direction (dx, dy) is (-dy, dx).
  const Image field = RandomField(24, 24, 5);
  Outline outline;
  ExtractOutline(field, 0.5f, &outline);
  int checked = 0;
  for (int s = 0; s < outline.segments.cols(); ++s) {
    const Eigen::Vector2d a = outline.points.col(outline.segments(0, s));
    const Eigen::Vector2d b = outline.points.col(outline.segments(1, s));
    const Eigen::Vector2d d = b - a, middle = 0.5 * (a + b);
    if (d.norm() < 1e-2) continue;
    const Eigen::Vector2d right = 1e-5 / d.norm() * Eigen::Vector2d(-d[1], d[0]);
    ASSERT_TRUE(InsideOutline(field, 0.5f, middle + right)) << middle.transpose();
    ASSERT_FALSE(InsideOutline(field, 0.5f, middle - right)) << middle.transpose();
    ++checked;
  }
  EXPECT_GT(checked, 100);
}

TEST(MarchingSquaresTest, InsideIsThatOfTheField) {
  const Image field = RandomField(24, 24, 6);
  for (int y = 0; y < 24; ++y) {
    for (int x = 0; x < 24; ++x) {
      EXPECT_EQ(InsideOutline(field, 0.5f, {x, y}), *field.at(x, y) >= 0.5f);
    }
  }
}

TEST(MarchingSquaresTest, InsideChangesOnlyAcrossTheOutline) {
  const Image field = RandomField(12, 12, 7);
  Outline outline;
  ExtractOutline(field, 0.5f, &outline);
  constexpr int kFine = 16;
  Outline scaled = outline;
  scaled.points = kFine * outline.points;
  const int size = 11 * kFine + 1;
  OutlineDistance distance;
  MeasureOutline(scaled, size, size, 2, &distance);
  for (int y = 0; y < size; ++y) {
    for (int x = 1; x < size; ++x) {
      const auto inside = [&](int x) {
        return InsideOutline(field, 0.5f, Eigen::Vector2d(x, y) / kFine);
      };
      if (inside(x) == inside(x - 1)) continue;
      ASSERT_LE(distance.distance[y * size + x], 1.0) << x << " " << y;
    }
  }
}

TEST(MarchingSquaresTest, ASaddleJoinsTheStrongerDiagonal) {
  for (const bool inside_is_stronger : {true, false}) {
    const float in = inside_is_stronger ? 0.9f : 0.6f;
    const Image field = FieldOf(2, 2, {in, 0.2f, 0.2f, in});
    EXPECT_EQ(InsideOutline(field, 0.5f, {0.5, 0.5}), inside_is_stronger);
  }
  // Of a binary mask the inside is joined, whichever diagonal it is on.
  EXPECT_TRUE(InsideOutline(FieldOf(2, 2, {1, 0, 0, 1}), 0.5f, {0.5, 0.5}));
  EXPECT_TRUE(InsideOutline(FieldOf(2, 2, {0, 1, 1, 0}), 0.5f, {0.5, 0.5}));
}

}  // namespace
}  // namespace cagefit
