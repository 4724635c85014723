#include "core/fit/alignment.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/base/parallel.h"
#include "core/base/random.h"
#include "core/cloud/kd_tree.h"
#include "core/mesh/area_sampler.h"

namespace cagefit {

namespace {

constexpr int64_t kPoints = 2000;  // of either side
constexpr int kSteps = 40;
constexpr double kCap = 0.1;
constexpr double kFirstScale = 0.3, kLastScale = 0.02, kScaleFactor = 0.85;  // of the kernel
constexpr double kSmallStep = 1e-6;
// A rigid motion has less to find, and what is left to do the fit does better.
constexpr int kRigidSteps = 20;
constexpr double kRigidScaleFactor = 0.7;
constexpr double kSmallRigidStep = 1e-4;
constexpr int64_t kRigidTargetPoints = 10'000;
constexpr double kLeastGain = 0.5;
constexpr double kDamping = 1e-6;
constexpr uint64_t kSeed = 1;

struct OrientedPoints {
  Points3d points, normals;
};

OrientedPoints Sample(const TriangleMesh& mesh) {
  OrientedPoints out;
  const AreaSampler sampler(mesh.vertices, mesh.triangles);
  if (!sampler.has_area()) return out;
  out.points.resize(3, kPoints);
  out.normals.resize(3, kPoints);
  Random random(kSeed);
  for (int64_t k = 0; k < kPoints; ++k) {
    const AreaSampler::Point at = sampler.Draw(&random);
    Eigen::Matrix3d corners;
    for (int c = 0; c < 3; ++c) {
      corners.col(c) = mesh.vertices.col(mesh.triangles(c, at.triangle));
    }
    out.points.col(k) = corners * at.weights;
    out.normals.col(k) =
        (corners.col(1) - corners.col(0)).cross(corners.col(2) - corners.col(0)).normalized();
  }
  return out;
}

OrientedPoints Sample(const PointCloud& cloud) {
  OrientedPoints out;
  const int64_t count = std::min(kPoints, cloud.size());
  out.points.resize(3, count);
  out.normals.resize(3, count);
  for (int64_t k = 0; k < count; ++k) {
    out.points.col(k) = cloud.points.col(k * cloud.size() / count).cast<double>();
    out.normals.col(k) = cloud.normals.col(k * cloud.size() / count).cast<double>();
  }
  return out;
}

struct Spread {
  Eigen::Vector3d centroid;
  double radius;  // root mean square
};

Spread SpreadOf(const Points3d& points) {
  const Eigen::Vector3d centroid = points.rowwise().mean();
  return {centroid, std::sqrt((points.colwise() - centroid).squaredNorm() /
                              static_cast<double>(points.cols()))};
}

class Aligner {
 public:
  Aligner(OrientedPoints surface, const PointCloud& target)
      : surface_(std::move(surface)),
        target_(Sample(target)),
        spread_(SpreadOf(target_.points)),
        cloud_(target),
        cloud_tree_(target.points),
        surface_points_(surface_.points.cast<float>()),
        surface_tree_(surface_points_) {}

  Similarity ByCentroid() const {
    const Spread from = SpreadOf(surface_.points), &to = spread_;
    Similarity T;
    T.scale = to.radius / from.radius;
    T.translation = to.centroid - T.scale * from.centroid;
    return T;
  }

  Similarity Iterate(Similarity T) const {
    double scale = kFirstScale;
    for (int step = 0; step < kSteps; ++step) {
      const double moved = Step(scale, Freedom::kSimilar, &T);
      if (scale == kLastScale && moved < kSmallStep) break;
      scale = std::max(kLastScale, scale * kScaleFactor);
    }
    return T;
  }

  Similarity IterateRigidly() const {
    Similarity T, by_centroid = ByCentroid();
    by_centroid.translation += (by_centroid.scale - 1) * SpreadOf(surface_.points).centroid;
    by_centroid.scale = 1;
    if (Misfit(by_centroid) < Misfit(T)) T = by_centroid;
    double scale = kFirstScale;
    for (int step = 0; step < kRigidSteps; ++step) {
      const double moved = Step(scale, Freedom::kRigid, &T);
      if (scale == kLastScale && moved < kSmallRigidStep) break;
      scale = std::max(kLastScale, scale * kRigidScaleFactor);
    }
    return T;
  }

  // Mean squared distance, both ways.
  double Misfit(const Similarity& T) const {
    double sum = 0;
    for (int side = 0; side < 2; ++side) {
      const int64_t count = Count(side);
      sum += ParallelSum(count, kGrain,
                         [&](int64_t begin, int64_t end) {
                           double part = 0;
                           for (int64_t k = begin; k < end; ++k) {
                             const double d = std::min(kCap, Find(side, k, T).offset.norm());
                             part += d * d;
                           }
                           return part;
                         }) /
             static_cast<double>(count);
    }
    return sum;
  }

 private:
  static constexpr int64_t kGrain = 256;
  using Vector7d = Eigen::Matrix<double, 7, 1>;

  // A point of the surface with its partner in the target.
  struct Pair {
    Eigen::Vector3d x, offset, normal;  // on the surface; from the partner to it; of the partner
    double agreement;                   // of the two normals: their cosine
  };

  int64_t Count(int side) const { return (side == 0 ? surface_ : target_).points.cols(); }

  // Side 0: point k of the surface and the nearest of the target; side 1: the other way round.
  Pair Find(int side, int64_t k, const Similarity& T) const {
    int32_t nearest = 0;
    float squared = 0;
    Pair pair;
    if (side == 0) {
      pair.x = T * Eigen::Vector3d(surface_.points.col(k));
      cloud_tree_.Nearest(pair.x.cast<float>(), 1, &nearest, &squared);
      pair.offset = pair.x - cloud_.points.col(nearest).cast<double>();
      pair.normal = cloud_.normals.col(nearest).cast<double>();
      pair.agreement = pair.normal.dot(T.rotation * surface_.normals.col(k));
      return pair;
    }
    const Eigen::Vector3d p = target_.points.col(k);
    surface_tree_.Nearest(T.Inverse(p).cast<float>(), 1, &nearest, &squared);
    pair.x = T * Eigen::Vector3d(surface_.points.col(nearest));
    pair.offset = pair.x - p;
    pair.normal = T.rotation * surface_.normals.col(nearest);
    pair.agreement = pair.normal.dot(target_.normals.col(k));
    return pair;
  }

  enum class Freedom { kRigid, kSimilar };

  // One Gauss-Newton step: x moves by w x (x - c) + t + s (x - c), c the centroid of the points,
  // s = 0 where it is rigid. Returns how far, in root mean square.
  double Step(double scale, Freedom freedom, Similarity* T) const {
    const Eigen::Vector3d& c = spread_.centroid;
    Eigen::Matrix<double, 7, 7> A = decltype(A)::Zero();
    Vector7d b = Vector7d::Zero();
    for (int side = 0; side < 2; ++side) {
      const int64_t count = Count(side);
      std::vector<Pair> pairs(count);
      ParallelFor(count, kGrain, [&](int64_t begin, int64_t end) {
        for (int64_t k = begin; k < end; ++k) pairs[k] = Find(side, k, *T);
      });
      for (const Pair& pair : pairs) {
        if (pair.agreement <= 0) continue;
        const double root = 1 + pair.offset.squaredNorm() / (scale * scale);
        const double weight = pair.agreement / (root * root * static_cast<double>(count));
        const Eigen::Vector3d arm = (pair.x - c) / spread_.radius;
        Vector7d J;
        J << arm.cross(pair.normal), pair.normal, arm.dot(pair.normal);
        A += weight * J * J.transpose();
        b -= weight * pair.normal.dot(pair.offset) * J;
      }
    }
    if (freedom == Freedom::kRigid) {
      A.row(6).setZero();
      A.col(6).setZero();
      b[6] = 0;
    }
    A.diagonal().array() += kDamping * A.trace() + 1e-300;
    const Vector7d x = A.ldlt().solve(b);
    Similarity step;
    step.scale = std::clamp(1 + x[6] / spread_.radius, 0.5, 2.0);
    const Eigen::Vector3d turn = x.head<3>() / spread_.radius;
    if (turn.norm() > 0) {
      step.rotation = Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix();
    }
    step.translation = c + x.segment<3>(3) - step.scale * (step.rotation * c);
    T->translation = step * T->translation;
    T->rotation = step.rotation * T->rotation;
    T->scale *= step.scale;
    return x.norm();
  }

  const OrientedPoints surface_, target_;
  const Spread spread_;  // of the target
  const PointCloud& cloud_;
  const KdTree cloud_tree_;
  const Points3f surface_points_;
  const KdTree surface_tree_;
};

}  // namespace

Similarity AlignRigidly(const TriangleMesh& surface, const PointCloud& target) {
  OrientedPoints samples = Sample(surface);
  if (samples.points.cols() == 0) return {};
  PointCloud thinned;
  const int64_t count = std::min(kRigidTargetPoints, target.size());
  thinned.points.resize(3, count);
  thinned.normals.resize(3, count);
  for (int64_t k = 0; k < count; ++k) {
    thinned.points.col(k) = target.points.col(k * target.size() / count);
    thinned.normals.col(k) = target.normals.col(k * target.size() / count);
  }
  const Similarity T = Aligner(std::move(samples), thinned).IterateRigidly();
  return T.translation.allFinite() && T.rotation.allFinite() ? T : Similarity();
}

Similarity AlignToTarget(const TriangleMesh& surface, const PointCloud& target) {
  OrientedPoints samples = Sample(surface);
  if (samples.points.cols() == 0) return {};
  const Aligner aligner(std::move(samples), target);
  Similarity best;
  double least = kLeastGain * aligner.Misfit(best);
  for (const Similarity& start : {Similarity(), aligner.ByCentroid()}) {
    const Similarity end = aligner.Iterate(start);
    const double misfit = aligner.Misfit(end);
    if (!(misfit < least)) continue;  // also where it is not a number
    least = misfit;
    best = end;
  }
  return best;
}

}  // namespace cagefit
