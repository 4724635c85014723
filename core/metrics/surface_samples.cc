#include "core/metrics/surface_samples.h"

#include <vector>

#include "core/base/random.h"
#include "core/mesh/area_sampler.h"

namespace cagefit {

namespace {

std::vector<int32_t> UsedVertices(const TriangleMesh& mesh) {
  std::vector<char> used(mesh.vertices.cols(), 0);
  for (int64_t k = 0; k < mesh.triangles.size(); ++k) used[mesh.triangles.data()[k]] = 1;
  std::vector<int32_t> indices;
  for (int32_t v = 0; v < mesh.vertices.cols(); ++v) {
    if (used[v]) indices.push_back(v);
  }
  return indices;
}

}  // namespace

Points3d SampleSurface(const TriangleMesh& mesh, int per_face, uint64_t seed) {
  const std::vector<int32_t> used = UsedVertices(mesh);
  const AreaSampler by_area(mesh.vertices, mesh.triangles);
  const int64_t drawn = by_area.has_area() ? per_face * mesh.triangles.cols() : 0;
  Points3d points(3, static_cast<int64_t>(used.size()) + drawn);
  int64_t count = 0;
  for (const int32_t v : used) points.col(count++) = mesh.vertices.col(v);
  Random random(seed);
  for (int64_t k = 0; k < drawn; ++k) {
    const AreaSampler::Point point = by_area.Draw(&random);
    const auto corner = [&](int c) { return mesh.vertices.col(mesh.triangles(c, point.triangle)); };
    points.col(count++) =
        point.weights[0] * corner(0) + point.weights[1] * corner(1) + point.weights[2] * corner(2);
  }
  return points;
}

}  // namespace cagefit
