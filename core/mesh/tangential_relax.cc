#include "core/mesh/tangential_relax.h"

#include <Eigen/Geometry>
#include <utility>
#include <vector>

namespace cagefit {

namespace {

std::vector<char> FreeVertices(const ControlMesh& mesh) {
  std::vector<char> free(mesh.vertex_count(), 1);
  for (int32_t v = 0; v < mesh.vertex_count(); ++v) free[v] = !mesh.topology().IsBoundaryVertex(v);
  for (const auto& [a, b] : mesh.tags().edges) free[a] = free[b] = 0;
  for (const int32_t v : mesh.tags().corners) free[v] = 0;
  return free;
}

Eigen::Vector3d Relaxed(const Points3d& V, int32_t v, absl::Span<const int32_t> ring) {
  Eigen::Vector3d x = V.col(v);
  Eigen::Vector3d mean = Eigen::Vector3d::Zero(), normal = Eigen::Vector3d::Zero();
  for (size_t k = 0; k < ring.size(); ++k) {
    const Eigen::Vector3d a = V.col(ring[k]), b = V.col(ring[(k + 1) % ring.size()]);
    mean += a;
    normal += (a - x).cross(b - x);
  }
  const Eigen::Vector3d step = 0.5 * (mean / static_cast<double>(ring.size()) - x);
  const double squared = normal.squaredNorm();
  if (!(squared > 0)) return x;  // a ring without a plane
  return x + step - normal * (normal.dot(step) / squared);
}

}  // namespace

ControlMesh RelaxTangentially(const ControlMesh& mesh, int steps) {
  const std::vector<char> free = FreeVertices(mesh);
  Points3d V = mesh.vertices(), next = V;
  for (int step = 0; step < steps; ++step) {
    for (int32_t v = 0; v < mesh.vertex_count(); ++v) {
      if (free[v]) next.col(v) = Relaxed(V, v, mesh.topology().Ring(v));
    }
    V = next;
  }
  return mesh.WithVertices(std::move(V));
}

}  // namespace cagefit
