#include "core/metrics/surface_samples.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

namespace cagefit {

namespace {

// std::uniform_real_distribution differs between libraries.
double Uniform(std::mt19937_64* random) { return static_cast<double>((*random)() >> 11) * 0x1p-53; }

std::vector<int32_t> UsedVertices(const TriangleMesh& mesh) {
  std::vector<char> used(mesh.vertices.cols(), 0);
  for (int64_t k = 0; k < mesh.triangles.size(); ++k) used[mesh.triangles.data()[k]] = 1;
  std::vector<int32_t> indices;
  for (int32_t v = 0; v < mesh.vertices.cols(); ++v) {
    if (used[v]) indices.push_back(v);
  }
  return indices;
}

// Entry f: area of triangles 0 to f.
std::vector<double> CumulativeAreas(const TriangleMesh& mesh) {
  std::vector<double> cumulative(mesh.triangles.cols());
  double sum = 0;
  for (int64_t f = 0; f < mesh.triangles.cols(); ++f) {
    const Eigen::Vector3d a = mesh.vertices.col(mesh.triangles(0, f));
    const Eigen::Vector3d b = mesh.vertices.col(mesh.triangles(1, f));
    const Eigen::Vector3d c = mesh.vertices.col(mesh.triangles(2, f));
    sum += 0.5 * (b - a).cross(c - a).norm();
    cumulative[f] = sum;
  }
  return cumulative;
}

}  // namespace

Points3d SampleSurface(const TriangleMesh& mesh, int per_face, uint64_t seed) {
  const std::vector<int32_t> used = UsedVertices(mesh);
  const std::vector<double> cumulative = CumulativeAreas(mesh);
  const bool has_area = !cumulative.empty() && cumulative.back() > 0;
  const int64_t drawn = has_area ? per_face * mesh.triangles.cols() : 0;
  Points3d points(3, static_cast<int64_t>(used.size()) + drawn);
  int64_t count = 0;
  for (const int32_t v : used) points.col(count++) = mesh.vertices.col(v);
  std::mt19937_64 random(seed);
  for (int64_t k = 0; k < drawn; ++k) {
    const double at = Uniform(&random) * cumulative.back();
    const int64_t f = std::min<int64_t>(
        std::upper_bound(cumulative.begin(), cumulative.end(), at) - cumulative.begin(),
        mesh.triangles.cols() - 1);
    // (1 - sqrt r) a + sqrt r (1 - s) b + sqrt r s c is uniform in the triangle.
    const double root = std::sqrt(Uniform(&random)), s = Uniform(&random);
    points.col(count++) = (1 - root) * mesh.vertices.col(mesh.triangles(0, f)) +
                          root * (1 - s) * mesh.vertices.col(mesh.triangles(1, f)) +
                          root * s * mesh.vertices.col(mesh.triangles(2, f));
  }
  return points;
}

}  // namespace cagefit
