// How far points of the target are from the limit surface: what the distance of samples to the
// target never asks.
//
//   E_cov = gamma (n/K) sum_k rho( (d_k . (p_k - X_k))^2 )
//
// n control vertices, K target points p_k, X_k the point of the limit surface closest to p_k, d_k
// the surface's normal there or, where a boundary or a crease holds the foot back, the unit vector
// from X_k to p_k, rho a robust kernel.
// The foot of p_k, as (face, u, v), and d_k are chosen by Assign and held fixed for value, gradient
// and step acceptance: X_k = sum_j s_kj V_j is linear in V, and so is the residual, which equals
// the distance of p_k where it was assigned. Sliding along the surface costs nothing, at a boundary
// the surface is drawn out to the points beyond it.
//
// A point whose normal faces against the surface's at its foot takes no part: it belongs to another
// sheet. Nor does one that is farther away than two mean edges of the control mesh at the first
// Assign, or than one beyond a boundary: it may belong to a part that the surface does not have,
// and would pull it out of shape. Nearer ones come into reach step by step.
//
// The Gauss-Newton matrix moves the foot with its triangle of the limit mesh of M1: with b_kc the
// barycentric weights of the foot in that triangle and Q_c its vertices,
//
//   1/2 dV^T H dV = sum_k w_k (d_k . sum_c b_kc dQ_c)^2,   w_k = gamma (n/K) rho'
//
// has one 3 x 3 block per vertex of M1 and one per edge, however many points there are, and differs
// from that of the exact rows by the second order in the size of M1's triangles.
#ifndef CAGEFIT_CORE_ENERGY_COVERAGE_TERM_H_
#define CAGEFIT_CORE_ENERGY_COVERAGE_TERM_H_

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "absl/types/span.h"
#include "core/cloud/point_cloud.h"
#include "core/energy/refined_surface.h"
#include "core/energy/robust_kernel.h"
#include "core/mesh/control_mesh.h"
#include "core/subdiv/limit_surface.h"
#include "core/subdiv/surface_projector.h"

namespace cagefit {

// Not thread-safe. Structure is built once; buffers keep their capacity.
class CoverageTerm {
 public:
  // Feet are sought to within `foot_tolerance`, relative to the longest edge of their control
  // triangle, and again when they have moved four times as far. Along the normal a foot that is off
  // by e changes the distance by the surface's curvature times e^2 / 2.
  // `m1` is that of the same mesh; null: made here.
  CoverageTerm(const Topology& topology, const CreaseTags& tags, double foot_tolerance = 1e-5,
               std::shared_ptr<const RefinedSurface> m1 = nullptr);
  CoverageTerm(const CoverageTerm&) = delete;

  // Copies at most `points` points of `target` (with normals), evenly spread over their order.
  // `weight` is gamma; 0 or no target: the term is off and everything below is 0.
  void SetTarget(const PointCloud* target, int64_t points, double weight,
                 const RobustKernel& kernel);
  // Multiplies the kernel's scale. A coarse problem takes every
  // kCoarseStride-th point only, from the next Assign on.
  void SetCoarseness(double kernel_factor, bool is_coarse) {
    scaled_kernel_.scale = kernel_factor * kernel_.scale;
    stride_ = is_coarse ? kCoarseStride : 1;
  }
  static constexpr int64_t kCoarseStride = 4;
  bool is_on() const { return weight_ > 0; }

  // Finds the feet at V (3 x n) and returns the energy.
  double Assign(const Points3d& V);
  // Energy at V with the feet of the last Assign.
  double Evaluate(const Points3d& V);
  // Adds half the gradient of the last evaluation (3 x n).
  void AddHalfGradient(Points3d* half_gradient) const;

  const std::shared_ptr<const RefinedSurface>& m1() const { return m1_; }
  // Adds the blocks of the last evaluation.
  void AddBlocks(SurfaceBlocks* blocks) const;

  // One point of the target that takes part, for solvers that want its row: over the points of
  // LimitSurface::ControlPoints.
  struct Row {
    absl::Span<const std::pair<int32_t, double>> entries;
    Eigen::Vector3d direction, target;  // d_k, p_k
    double scale;                       // gamma n/K
  };
  int64_t size() const { return is_on() ? points_.cols() : 0; }
  bool is_used(int64_t k) const { return feet_[k].used; }
  Row row(int64_t k) const;
  const RobustKernel& kernel() const { return scaled_kernel_; }
  const LimitSurface& surface() const { return surface_; }

 private:
  struct Foot {
    bool used = false;
    bool is_free = false;          // the direction is the surface's normal
    int32_t begin = 0, count = 0;  // of its row, in its chunk
    int32_t triangle = 0;          // of M1
    Eigen::Vector3d barycentric = Eigen::Vector3d::Zero();
    Eigen::Vector3d direction = Eigen::Vector3d::Zero();
    double residual = 0, weight = 0;  // at the last evaluation: rho'
    SurfacePoint at;
  };
  // Entries of the rows of consecutive points, written by one thread.
  using Entries = std::vector<std::pair<int32_t, double>>;
  struct Chunk {
    Entries entries, last;  // after and before the last Assign
  };

  Eigen::Vector3d Offset(int64_t k, const Entries& entries, const Points3d& control_points) const;
  double EdgeLength(int32_t face) const;  // of one edge of the control triangle
  bool Stays(int64_t k, const Chunk& chunk);
  void AssignPoint(int64_t k, Chunk* chunk);
  double Energy(Foot* foot) const;
  double PointWeight() const;  // gamma n/K, K the points of the last Assign

  const double foot_tolerance_;
  LimitSurface surface_;
  std::shared_ptr<const RefinedSurface> m1_;
  SurfaceProjector projector_;
  StencilMatrix refinement_transposed_;
  double weight_ = 0;
  int64_t stride_ = 1;
  int64_t assigned_stride_ = 0;  // of the last Assign; 0: there was none
  RobustKernel kernel_, scaled_kernel_;
  double edge_ = 0;            // mean of the control mesh at the first Assign
  Points3d points_, normals_;  // 3 x K
  Points3d control_points_;
  mutable Points3d pull_;  // 3 x control points: work space of AddHalfGradient
  std::vector<Foot> feet_;
  std::vector<Chunk> chunks_;
};

}  // namespace cagefit

#endif  // CAGEFIT_CORE_ENERGY_COVERAGE_TERM_H_
