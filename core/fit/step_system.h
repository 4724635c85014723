// The damped normal equations of one Gauss-Newton step, matrix-free, and their solution by
// preconditioned conjugate gradients.
//
//   ( S^T A S + L^T B L + alpha H_arap + lambda D ) step = -g/2
//
// A holds one 3 x 3 block per row of Objective::block_stencils, of a sample
// n/m (rho' grad f grad f^T + grad b grad b^T), and the blocks of coverage and images for vertices
// and edges of M1 (energy/refined_surface.h); L and B hold rows and weights of the attachments
// (energy/attachments.h), of which there are few; H_arap is that of energy/arap_term.h; D is the
// mean diagonal. The preconditioner is the inverse of the 3 x 3 diagonal blocks. Vectors are single
// precision, four lanes a vertex: the step is inexact by design, gradient and energy stay double.
#ifndef CAGEFIT_CORE_FIT_STEP_SYSTEM_H_
#define CAGEFIT_CORE_FIT_STEP_SYSTEM_H_

#include <Eigen/Core>
#include <vector>

#include "core/base/cancel.h"
#include "core/fit/objective.h"

namespace cagefit {

// Not thread-safe. Structure is built once.
class StepSystem {
 public:
  explicit StepSystem(const Objective& objective);

  // Takes over the numbers of the objective's last evaluation.
  void Linearize(const Objective& objective);

  // Solves to a relative residual (in the preconditioner's norm) of `tolerance`, or max_iterations.
  // Writes the step (3 x n) and the predicted decrease of the energy, and returns the number of
  // iterations. Stops early, with the step so far, when cancelled.
  int Solve(const Points3d& half_gradient, double damping, double tolerance, int max_iterations,
            const CancelFn& cancelled, Points3d* step, double* predicted_decrease);

 private:
  using Vec = Eigen::Vector4f;  // x y z 0
  using Vecs = std::vector<Vec, Eigen::aligned_allocator<Vec>>;

  void LinkRows(const Objective& objective);
  void LinearizeRows(const Objective& objective);
  void AddAttachments(const Objective& objective);
  void Precondition(double damping);
  void ApplyLinked();
  void ApplyAttachments(const Vecs& x, Vecs* y) const;
  void Apply(const Vecs& x, float damping, Vecs* y);

  // Structure: S and its transpose, half-edges with their reverse.
  std::vector<int32_t> row_begin_, row_index_, column_begin_, column_index_;
  std::vector<float> row_weight_, column_weight_;
  // Neighbours of every vertex of M1, as rows, with the edges to them; empty where nothing acts on
  // it.
  std::vector<int32_t> link_begin_, link_row_, link_edge_;
  int64_t surface_begin_ = 0;
  std::vector<int32_t> edge_begin_, edge_neighbor_, edge_reverse_;
  int64_t rows_ = 0, vertices_ = 0;

  // Attachments that take part: rows over the control vertices, three columns of B each.
  std::vector<int32_t> attached_begin_, attached_index_;
  std::vector<float> attached_weight_;
  Vecs attached_columns_;

  // Numbers of the current linearisation.
  Vecs block_columns_;  // of A: three a row
  Vecs link_columns_;   // three per edge of M1
  SurfaceBlocks surface_;
  bool linked_ = false;             // surface_ holds something
  std::vector<float> edge_weight_;  // alpha w_ij, per half-edge
  Vecs edge_;                       // alpha w_ij R_i (V'_i - V'_j), per half-edge
  Vecs edge_sum_;                   // its sum over j, per vertex
  std::vector<Eigen::Matrix4f, Eigen::aligned_allocator<Eigen::Matrix4f>> inverse_inertia_;
  std::vector<Eigen::Matrix3d> diagonal_;  // without damping
  float mean_diagonal_ = 0;
  bool rigid_ = false;  // alpha > 0

  // Work space.
  std::vector<Eigen::Matrix4f, Eigen::aligned_allocator<Eigen::Matrix4f>> inverse_diagonal_;
  Vecs row_in_, row_out_, turn_, x_, r_, z_, p_, q_;
};

}  // namespace cagefit

#endif  // CAGEFIT_CORE_FIT_STEP_SYSTEM_H_
