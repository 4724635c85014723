// The limit surface as the mesh M1: what terms that act at points of it share, so that a
// Gauss-Newton matrix has their blocks in common.
#ifndef CAGEFIT_CORE_ENERGY_REFINED_SURFACE_H_
#define CAGEFIT_CORE_ENERGY_REFINED_SURFACE_H_

#include <Eigen/Core>
#include <vector>

#include "core/mesh/control_mesh.h"
#include "core/mesh/topology.h"
#include "core/subdiv/stencils.h"

namespace cagefit {

// Immutable.
struct RefinedSurface {
  RefinedSurface(const Topology& control, const CreaseTags& tags);

  Topology topology;         // of M1
  StencilMatrix position;    // limit positions of its vertices x control vertices
  StencilMatrix transposed;  // the transpose of that
};

// Half the second derivatives of an energy sum_k w_k (d_k . sum_c b_kc dQ_c)^2 of the vertices Q of
// M1, with weights b_kc at the ends of an edge or the corners of a triangle. All are symmetric.
struct SurfaceBlocks {
  std::vector<Eigen::Matrix3f> vertex;  // sum_k b_kc^2 w_k d_k d_k^T
  std::vector<Eigen::Matrix3f> edge;    // sum_k b_kc b_kc' w_k d_k d_k^T
  std::vector<Eigen::Matrix3f> lumped;  // of a vertex, its row's sum: sum_k b_kc w_k d_k d_k^T

  void SetZero(const Topology& m1) {
    vertex.assign(m1.vertex_count(), Eigen::Matrix3f::Zero());
    lumped.assign(m1.vertex_count(), Eigen::Matrix3f::Zero());
    edge.assign(m1.edge_count(), Eigen::Matrix3f::Zero());
  }
};

}  // namespace cagefit

#endif  // CAGEFIT_CORE_ENERGY_REFINED_SURFACE_H_
