#include "core/metrics/drift.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cassert>
#include <cmath>

#include "core/base/parallel.h"

namespace cagefit {

namespace {

constexpr int64_t kGrain = 1024;

class Tally {
 public:
  void Add(const Eigen::Vector3d& drift, const Eigen::Vector3d& normal) {
    ++count_;
    stats_.mean += drift.norm();
    squares_ += drift.squaredNorm();
    stats_.max = std::max(stats_.max, drift.norm());
    stats_.tangential_mean += (drift - normal.dot(drift) * normal).norm();
  }

  DriftStats Stats() const {
    const auto count = static_cast<double>(std::max<int64_t>(1, count_));
    DriftStats stats = stats_;
    stats.mean /= count;
    stats.tangential_mean /= count;
    stats.rms = std::sqrt(squares_ / count);
    return stats;
  }

 private:
  DriftStats stats_;  // sums of the means
  double squares_ = 0;
  int64_t count_ = 0;
};

}  // namespace

DriftMeter::DriftMeter(const TriangleMesh& fit, const Points3d& truth)
    : triangles_(fit.triangles), bound_(truth.cols()), truth_(truth) {
  const TriangleBvh surface(fit.vertices, fit.triangles);
  ParallelFor(truth.cols(), kGrain, [&](int64_t begin, int64_t end) {
    for (int64_t i = begin; i < end; ++i) bound_[i] = surface.Closest(truth.col(i));
  });
}

DriftStats DriftMeter::Measure(const Points3d& fit_vertices, const Points3d& truth) const {
  assert(truth.cols() == truth_.cols());
  Tally tally;
  for (int64_t i = 0; i < truth.cols(); ++i) {
    const ClosestPoint& at = bound_[i];
    const Eigen::Vector3d a = fit_vertices.col(triangles_(0, at.triangle));
    const Eigen::Vector3d ab = fit_vertices.col(triangles_(1, at.triangle)) - a;
    const Eigen::Vector3d ac = fit_vertices.col(triangles_(2, at.triangle)) - a;
    const Eigen::Vector3d moved = a + at.u * ab + at.v * ac - at.point;
    tally.Add(moved - (truth.col(i) - truth_.col(i)), ab.cross(ac).normalized());
  }
  return tally.Stats();
}

DriftStats RoundTripDrift(const TriangleMesh& fit, const Points3d& returned) {
  assert(returned.cols() == fit.vertices.cols());
  const Points3d normals = VertexNormals(fit);
  Tally tally;
  for (int64_t i = 0; i < returned.cols(); ++i) {
    tally.Add(returned.col(i) - fit.vertices.col(i), normals.col(i));
  }
  return tally.Stats();
}

DriftStats Combine(const std::vector<DriftStats>& frames) {
  DriftStats out;
  double squares = 0;
  for (const DriftStats& frame : frames) {
    out.mean += frame.mean;
    out.tangential_mean += frame.tangential_mean;
    out.max = std::max(out.max, frame.max);
    squares += frame.rms * frame.rms;
  }
  const auto count = static_cast<double>(std::max<size_t>(1, frames.size()));
  out.mean /= count;
  out.tangential_mean /= count;
  out.rms = std::sqrt(squares / count);
  return out;
}

}  // namespace cagefit
