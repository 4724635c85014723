#include "core/cloud/noise.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "core/base/parallel.h"

namespace cagefit {

namespace {

constexpr int64_t kBalls = 256;
constexpr int64_t kFewestPoints = 500;  // with fewer, a ball is as large as what it should resolve
constexpr int kFirstBall = 32;          // points in the smallest balls
constexpr int kLeastPoints = 12;
constexpr int kMostPoints = 96;  // larger balls are thinned to half of this or more
constexpr double kSquaredRim = 0.6;
constexpr int kLevels = 12;  // radii grow by sqrt(2)
constexpr double kRadiusPerResidual = 4;
constexpr double kLargestBall = 0.14;   // of the diagonal
constexpr double kCurvatureGrowth = 3;  // of the squared residual, from one ball to the next
constexpr int kCoefficients = 6;
constexpr double kDeviationOfMedian = 1.4826;  // standard deviation of a normal distribution / MAD

using Coefficients = Eigen::Matrix<double, kCoefficients, 1>;

// The middle of values[0, count), which it reorders.
template <typename T>
T Median(T* values, int64_t count) {
  std::nth_element(values, values + count / 2, values + count);
  return values[count / 2];
}

struct Ball {
  int count = 0;
  Eigen::Matrix<double, 3, kMostPoints> points;
};

// Points within `radius` of x. Where there are more than fit, every second one, every fourth, and
// so on in the grid's order, which spreads them evenly.
void Gather(const CellGrid& grid, const Eigen::Vector3d& x, double radius, Ball* ball) {
  const double squared_radius = radius * radius;
  int32_t stride = 1, seen = 0;
  ball->count = 0;
  grid.ForEachRun(x, radius, [&](int32_t begin, int32_t end) {
    for (int32_t i = begin + (stride - seen % stride) % stride; i < end; i += stride) {
      const Eigen::Vector3d d = grid.point_at(i).cast<double>() - x;
      if (d.squaredNorm() > squared_radius) continue;
      if (ball->count == kMostPoints) {
        for (int k = 0; 2 * k < kMostPoints; ++k) ball->points.col(k) = ball->points.col(2 * k);
        ball->count = (kMostPoints + 1) / 2;
        stride *= 2;
      }
      ball->points.col(ball->count++) = d;
    }
    seen += end - begin;
  });
}

// Turns the points of the ball into (u, v, height) over their plane, about their mean, in radii.
// Those near the rim, where the ball cuts the noise off at a low height, are left out.
void ToPlane(double radius, Ball* ball) {
  auto points = ball->points.leftCols(ball->count);
  points = (points.colwise() - points.rowwise().mean().eval()) / radius;
  const Eigen::Matrix3d covariance = points * points.transpose();
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen;
  eigen.computeDirect(covariance);
  points = (eigen.eigenvectors().rowwise().reverse().transpose() * points).eval();
  int kept = 0;
  for (int k = 0; k < ball->count; ++k) {
    if (ball->points.col(k).head<2>().squaredNorm() > kSquaredRim) continue;
    ball->points.col(kept++) = ball->points.col(k);
  }
  ball->count = kept;
}

Coefficients Monomials(double u, double v) {
  return (Coefficients() << 1, u, v, u * u, u * v, v * v).finished();
}

// Replaces heights by what a quadric leaves of them, fitted twice: the second time without what is
// far off the first. Returns its standard deviation as the median tells it.
double FitQuadric(Ball* ball) {
  constexpr int kRounds = 2;
  constexpr double kFarOff = 4.5;  // standard deviations
  constexpr double kRidge = 1e-9;  // points on a line leave coefficients open
  const int count = ball->count;
  std::array<double, kMostPoints> residuals, sorted;
  double deviation = 0;
  for (int round = 0; round < kRounds; ++round) {
    Eigen::Matrix<double, kCoefficients, kCoefficients> A = decltype(A)::Identity() * kRidge;
    Coefficients b = Coefficients::Zero();
    for (int k = 0; k < count; ++k) {
      if (round > 0 && !(std::abs(residuals[k]) <= kFarOff * deviation)) continue;
      const Coefficients m = Monomials(ball->points(0, k), ball->points(1, k));
      A.noalias() += m * m.transpose();
      b += ball->points(2, k) * m;
    }
    const Coefficients x = A.ldlt().solve(b);
    for (int k = 0; k < count; ++k) {
      residuals[k] = ball->points(2, k) - x.dot(Monomials(ball->points(0, k), ball->points(1, k)));
      sorted[k] = std::abs(residuals[k]);
    }
    deviation = kDeviationOfMedian * Median(sorted.data(), count) *
                std::sqrt(count / static_cast<double>(count - kCoefficients));
  }
  for (int k = 0; k < count; ++k) ball->points(2, k) = residuals[k];
  return deviation;
}

// Standard deviation of the residuals from their differences between points next to each other.
double DeviationOfPairs(const Ball& ball) {
  std::array<double, kMostPoints> differences;
  for (int i = 0; i < ball.count; ++i) {
    double nearest = 1e300;
    int other = i;
    for (int j = 0; j < ball.count; ++j) {
      const double du = ball.points(0, j) - ball.points(0, i);
      const double dv = ball.points(1, j) - ball.points(1, i);
      const double squared = du * du + dv * dv;
      if (squared < nearest && j != i) nearest = squared, other = j;
    }
    differences[i] = std::abs(ball.points(2, i) - ball.points(2, other));
  }
  return kDeviationOfMedian * Median(differences.data(), ball.count) * std::sqrt(0.5);
}

// Medians over the balls of one level, in the cloud's units.
struct Level {
  double radius = 0, residual = 0, pairs = 0;

  double clearness() const { return radius / std::max(residual, 1e-300); }
  bool settled() const { return clearness() >= kRadiusPerResidual; }
};

class Balls {
 public:
  explicit Balls(const CellGrid& grid) : grid_(grid), radii_(std::min(grid.size(), kBalls)) {
    ParallelFor(count(), kGrain, [&](int64_t begin, int64_t end) {
      std::vector<float> scratch;
      for (int64_t k = begin; k < end; ++k) {
        radii_[k] = grid_.KthDistance(centre(k), kFirstBall, &scratch);
      }
    });
  }

  // Balls sqrt(2)^level times as large as at first. They cross the more cells the larger they are,
  // so there are fewer of them.
  Level Measure(int level) const {
    const double growth = std::pow(2.0, level / 2.0);
    const int64_t step = std::clamp<int64_t>(int64_t{1} << (level / 3), 1, kMostStep);
    const int64_t used = count() / step;
    std::vector<double> residuals(used, -1), pairs(used), radii(used);
    ParallelFor(used, kGrain, [&](int64_t begin, int64_t end) {
      Ball ball;
      for (int64_t k = begin; k < end; ++k) {
        const double radius = radii[k] = growth * radii_[k * step];
        if (!(radius > 0)) continue;
        Gather(grid_, centre(k * step), radius, &ball);
        ToPlane(radius, &ball);
        if (ball.count < kLeastPoints) continue;
        residuals[k] = radius * FitQuadric(&ball);
        pairs[k] = radius * DeviationOfPairs(ball);
      }
    });
    int64_t kept = 0;
    for (int64_t k = 0; k < used; ++k) {
      if (residuals[k] < 0) continue;
      radii[kept] = radii[k];
      residuals[kept] = residuals[k];
      pairs[kept++] = pairs[k];
    }
    if (kept == 0) return {};
    return {Median(radii.data(), kept), Median(residuals.data(), kept), Median(pairs.data(), kept)};
  }

 private:
  static constexpr int64_t kGrain = 8, kMostStep = 4;
  int64_t count() const { return static_cast<int64_t>(radii_.size()); }
  Eigen::Vector3d centre(int64_t k) const {
    return grid_.point_at(k * grid_.size() / count()).cast<double>();
  }

  const CellGrid& grid_;
  std::vector<double> radii_;
};

}  // namespace

NoiseEstimate EstimateNoise(const CellGrid& grid) {
  if (grid.size() < kFewestPoints) return {};
  const Balls balls(grid);
  std::array<Level, kLevels> levels;
  levels[0] = balls.Measure(0);
  int last = 0, clearest = 0;
  // One level beyond the first settled one, to compare it with. A noise of a third of the thickness
  // never settles; balls as large as the whole would, far too late.
  do {
    ++last;
    levels[last] = balls.Measure(last);
    if (levels[last].radius > kLargestBall * grid.diagonal()) break;
    if (levels[last].clearness() > levels[clearest].clearness()) clearest = last;
  } while (last + 1 < kLevels && !levels[last - 1].settled());
  const int first = levels[last - 1].settled() ? last - 1 : clearest;
  const Level& level = levels[first];
  // Clearest in the middle of the levels: smaller balls saw noise.
  if (first == last || (first > 0 && !level.settled())) return {level.pairs, level.radius};
  // e^2 = sigma^2 + c^2 here and sigma^2 + 3 c^2 in the next ball.
  const double ratio = levels[last].residual / std::max(level.residual, 1e-300);
  const double noise = (kCurvatureGrowth - ratio * ratio) / (kCurvatureGrowth - 1);
  return {level.pairs * std::sqrt(std::clamp(noise, 0.0, 1.0)), level.radius};
}

}  // namespace cagefit
