// As-rigid-as-possible regulariser [sorkine2007].
//
//   E_reg = sum_i sum_{j in N(i)} w_ij | (V_i - V_j) - R_i (V'_i - V'_j) |^2
//
// w_ij = (cot a_ij + cot b_ij) / 2 in the rest mesh V', at least kMinWeight; R_i the rotation that
// minimises the inner sum. Because R_i minimises E_reg, the gradient with R_i fixed is exact:
//
//   dE/dV_i = 2 sum_j w_ij ( 2 (V_i - V_j) - (R_i + R_j) (V'_i - V'_j) )
//
// The Gauss-Newton matrix lets the rotations follow: with e_ij = R_i (V'_i - V'_j) and dx_ij = dV_i
// - dV_j,
//
//   w_i = A_i^-1 sum_j w_ij e_ij x dx_ij,   A_i = sum_j w_ij (|e_ij|^2 I - e_ij e_ij^T)
//   1/2 dx^T H dx = sum_i sum_j w_ij | dx_ij - w_i x e_ij |^2
//
// so that a part that turns costs nothing, where fixed rotations would hold it back for many steps.
#ifndef CAGEFIT_CORE_ENERGY_ARAP_TERM_H_
#define CAGEFIT_CORE_ENERGY_ARAP_TERM_H_

#include <cstdint>
#include <vector>

#include "core/base/types.h"
#include "core/mesh/topology.h"

namespace cagefit {

// Not thread-safe. Connectivity is kept from Create on; buffers keep their capacity.
class ArapTerm {
 public:
  static constexpr double kMinWeight = 1e-3;

  explicit ArapTerm(const Topology& topology);

  // Sets the rest mesh (3 x n) and with it weights and A_i.
  void SetRest(const Points3d& rest);

  // Rotations for V: Newton from the ones before, which start as identities after SetRest.
  void UpdateRotations(const Points3d& V);

  // Energy at V with the rotations of the last update; writes half the gradient (3 x n) when it is
  // not null.
  double Evaluate(const Points3d& V, Points3d* half_gradient) const;

  // Half-edges i -> j in order of i: neighbours of i are entries begin(i) to begin(i + 1).
  int32_t begin(int32_t i) const { return begin_[i]; }
  int32_t neighbor(int32_t entry) const { return neighbor_[entry]; }
  double weight(int32_t entry) const { return weight_[entry]; }
  const Points3d& rest() const { return rest_; }
  const Eigen::Matrix3d& rotation(int32_t i) const { return rotation_[i]; }
  // A_i^-1 in the rest frame: A_i^-1 = R_i inverse_inertia R_i^T.
  const Eigen::Matrix3d& inverse_inertia(int32_t i) const { return inverse_inertia_[i]; }
  int32_t vertex_count() const { return static_cast<int32_t>(begin_.size()) - 1; }

 private:
  Triangles triangles_;
  std::vector<int32_t> begin_, neighbor_;
  std::vector<int32_t> triangle_entry_;  // 6 F: entries of half-edges (0,1) (1,0) (1,2) (2,1) (2,0)
                                         // (0,2) of each triangle
  std::vector<double> weight_;
  Points3d rest_;
  std::vector<Eigen::Matrix3d> rotation_, inverse_inertia_;
};

}  // namespace cagefit

#endif  // CAGEFIT_CORE_ENERGY_ARAP_TERM_H_
