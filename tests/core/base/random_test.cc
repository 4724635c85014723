#include "core/base/random.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace cagefit {
namespace {

constexpr double kTwoPi = 6.283185307179586;

// The numbers that the standard's engine gives, in the order in which they are drawn.
class Draws {
 public:
  explicit Draws(uint64_t seed) : engine_(seed) {}
  double Uniform() { return std::ldexp(static_cast<double>(engine_() >> 11), -53); }
  double Normal() {
    const double u = Uniform();
    const double v = Uniform();
    return std::sqrt(-2 * std::log(1 - u)) * std::cos(kTwoPi * v);
  }

 private:
  std::mt19937_64 engine_;
};

TEST(RandomTest, ASeedGivesTheSameNumbersEverywhere) {
  EXPECT_DOUBLE_EQ(Random(7).Uniform(), 0.75438530415285798);
  EXPECT_DOUBLE_EQ(Random(7).Normal(), 1.5913998756469563);
}

TEST(RandomTest, DrawsAreMadeInTheOrderOfTheCoordinates) {
  Random random(7);
  Draws draws(7);
  const Eigen::Vector3d uniform = random.UniformVector();
  for (int axis = 0; axis < 3; ++axis) EXPECT_EQ(uniform[axis], draws.Uniform()) << axis;
  const Eigen::Vector3d normal = random.NormalVector();
  for (int axis = 0; axis < 3; ++axis) EXPECT_DOUBLE_EQ(normal[axis], draws.Normal()) << axis;
}

TEST(RandomTest, NormalNumbersHaveMeanZeroAndVarianceOne) {
  Random random(1);
  constexpr int kCount = 100'000;
  double sum = 0, squares = 0;
  for (int i = 0; i < kCount; ++i) {
    const double x = random.Normal();
    sum += x;
    squares += x * x;
  }
  EXPECT_NEAR(sum / kCount, 0, 0.015);  // 5 standard errors
  EXPECT_NEAR(squares / kCount, 1, 0.023);
}

}  // namespace
}  // namespace cagefit
