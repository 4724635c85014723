#include "core/cloud/surface_cloud.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <vector>

namespace cagefit {

namespace {

// A fit samples the distance field: with fewer points than this on the whole surface there is none.
constexpr double kLeastPoints = 10'000;
constexpr double kLargeTriangle = 2;  // longest edge in spacings
// Where a mesh has more triangles, its vertices say enough.
constexpr int64_t kMostMiddles = 150'000;

struct Corners {
  Eigen::Vector3d a, ab, ac;

  Corners(const TriangleMesh& mesh, int64_t f)
      : a(mesh.vertices.col(mesh.triangles(0, f))),
        ab(mesh.vertices.col(mesh.triangles(1, f)) - a),
        ac(mesh.vertices.col(mesh.triangles(2, f)) - a) {}
  double longest_edge() const {
    return std::sqrt(std::max({ab.squaredNorm(), ac.squaredNorm(), (ac - ab).squaredNorm()}));
  }
  double area() const { return 0.5 * ab.cross(ac).norm(); }
};

double Spacing(const TriangleMesh& mesh) {
  std::vector<double> edges(mesh.triangles.cols());
  double area = 0;
  for (int64_t f = 0; f < mesh.triangles.cols(); ++f) {
    const Corners corners(mesh, f);
    edges[f] = corners.ab.norm();
    area += corners.area();
  }
  const auto middle = edges.begin() + static_cast<int64_t>(edges.size() / 2);
  std::nth_element(edges.begin(), middle, edges.end());
  return std::min(*middle, std::sqrt(area / kLeastPoints));
}

// A triangle is cut into k^2 like ones, k = Cuts. Of small triangles the middle stands for the
// inside, where the mesh has few enough of them.
int64_t Cuts(const TriangleMesh& mesh, const Corners& corners, double spacing) {
  const double ratio = corners.longest_edge() / spacing;
  if (!(corners.area() > 0)) return 0;
  if (!(ratio > kLargeTriangle)) return mesh.triangles.cols() <= kMostMiddles ? 1 : 0;
  return static_cast<int64_t>(std::ceil(std::min(ratio, 1e6)));
}

// k^2 of each triangle; the spacing grows until their sum is within `budget`.
std::vector<int64_t> PlanCuts(const TriangleMesh& mesh, int64_t budget) {
  double spacing = Spacing(mesh);
  std::vector<int64_t> cuts(mesh.triangles.cols(), 0);
  while (spacing > 0) {
    double sum = 0;
    for (int64_t f = 0; f < mesh.triangles.cols(); ++f) {
      cuts[f] = Cuts(mesh, Corners(mesh, f), spacing);
      sum += static_cast<double>(cuts[f]) * static_cast<double>(cuts[f]);
    }
    if (sum <= static_cast<double>(budget)) return cuts;
    spacing *= std::max(1.1, std::sqrt(sum / static_cast<double>(budget)));
  }
  std::fill(cuts.begin(), cuts.end(), 0);
  return cuts;
}

// Middles of the k^2 parts of a triangle.
void Fill(const Corners& corners, int64_t k, int64_t* count, PointCloud* cloud) {
  const Eigen::Vector3f normal = corners.ab.cross(corners.ac).normalized().cast<float>();
  const double step = 1.0 / static_cast<double>(k);
  for (int64_t i = 0; i < k; ++i) {
    for (int64_t j = 0; i + j < k; ++j) {
      // The part at (i, j) that stands like the whole, and the one that stands on its head.
      for (const double third : {1.0 / 3, 2.0 / 3}) {
        if (third > 0.5 && i + j + 1 >= k) continue;
        const double u = (static_cast<double>(i) + third) * step;
        const double v = (static_cast<double>(j) + third) * step;
        cloud->points.col(*count) = (corners.a + u * corners.ab + v * corners.ac).cast<float>();
        cloud->normals.col((*count)++) = normal;
      }
    }
  }
}

PointCloud VertexCloud(const TriangleMesh& mesh, const Points3f& normals) {
  if (normals.cols() == 0) return CloudFromMesh(mesh);
  std::vector<char> used(mesh.vertices.cols(), 0);
  for (int64_t k = 0; k < mesh.triangles.size(); ++k) used[mesh.triangles.data()[k]] = 1;
  PointCloud cloud;
  cloud.points.resize(3, mesh.vertices.cols());
  cloud.normals.resize(3, mesh.vertices.cols());
  int64_t count = 0;
  for (int64_t v = 0; v < mesh.vertices.cols(); ++v) {
    const Eigen::Vector3d normal = normals.col(v).cast<double>().stableNormalized();
    if (!used[v] || !(normal.squaredNorm() > 0.5)) continue;
    cloud.points.col(count) = mesh.vertices.col(v).cast<float>();
    cloud.normals.col(count++) = normal.cast<float>();
  }
  cloud.points.conservativeResize(3, count);
  cloud.normals.conservativeResize(3, count);
  return cloud;
}

}  // namespace

PointCloud SurfaceCloud(const TriangleMesh& mesh, const Points3f& normals) {
  PointCloud cloud = VertexCloud(mesh, normals);
  if (mesh.triangles.cols() == 0) return cloud;
  int64_t count = cloud.size();
  const std::vector<int64_t> cuts =
      PlanCuts(mesh, std::max(kFillOfSmallMesh, kMaxFillPerVertex * count));
  int64_t fill = 0;
  for (const int64_t k : cuts) fill += k * k;
  cloud.points.conservativeResize(3, count + fill);
  cloud.normals.conservativeResize(3, count + fill);
  for (int64_t f = 0; f < mesh.triangles.cols(); ++f) {
    if (cuts[f] > 0) Fill(Corners(mesh, f), cuts[f], &count, &cloud);
  }
  return cloud;
}

}  // namespace cagefit
