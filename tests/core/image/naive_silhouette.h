// The formula of soft_silhouette.h, word by word, in double precision: slow, and independent of the
// renderer.
#ifndef CAGEFIT_TESTS_CORE_IMAGE_NAIVE_SILHOUETTE_H_
#define CAGEFIT_TESTS_CORE_IMAGE_NAIVE_SILHOUETTE_H_

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>
#include <vector>

#include "core/image/camera.h"
#include "core/image/soft_silhouette.h"
#include "core/mesh/triangle_mesh.h"

namespace cagefit::testing {

struct NaivePixel {
  double value = 0;
  // How near the pixel's set of triangles is to being another one: the least distance of any number
  // that decides on it to its threshold (inside, blur radius, depth of the last that counts).
  double margin = 1e300;
};

inline double SquaredToSegment(const Eigen::Vector2d& p, const Eigen::Vector2d& a,
                               const Eigen::Vector2d& b) {
  const double l2 = (b - a).squaredNorm();
  const double t = l2 > 0 ? std::clamp((p - a).dot(b - a) / l2, 0.0, 1.0) : 0;
  return (p - a - t * (b - a)).squaredNorm();
}

inline NaivePixel NaiveSilhouette(const TriangleMesh& mesh, const Camera& camera,
                                  const SoftSilhouetteOptions& options, int x, int y) {
  const double unit = camera.half_side();
  const Eigen::Vector2d p = Eigen::Vector2d(x, y) / unit;
  struct Hit {
    double depth;
    int64_t face;
    double factor;
    bool operator<(const Hit& o) const { return std::tie(depth, face) < std::tie(o.depth, o.face); }
  };
  std::vector<Hit> hits;
  NaivePixel out;
  for (int64_t f = 0; f < mesh.triangles.cols(); ++f) {
    Eigen::Vector2d v[3];
    double z[3];
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3d q = camera.Project(mesh.vertices.col(mesh.triangles(k, f)));
      v[k] = q.head<2>() / unit;
      z[k] = q[2];
    }
    const auto edge = [](const Eigen::Vector2d& p, const Eigen::Vector2d& a,
                         const Eigen::Vector2d& b) {
      return (p[0] - a[0]) * (b[1] - a[1]) - (p[1] - a[1]) * (b[0] - a[0]);
    };
    const double area = edge(v[2], v[0], v[1]);
    if (std::abs(area) <= 1e-8) continue;
    double w[3] = {edge(p, v[1], v[2]) / area, edge(p, v[2], v[0]) / area,
                   edge(p, v[0], v[1]) / area};
    const bool inside = w[0] > 0 && w[1] > 0 && w[2] > 0;
    const double squared =
        std::min({SquaredToSegment(p, v[0], v[1]), SquaredToSegment(p, v[1], v[2]),
                  SquaredToSegment(p, v[2], v[0])});
    out.margin = std::min(
        {out.margin, std::sqrt(squared), inside ? 1e300 : std::abs(squared - options.blur_radius)});
    if (!inside && squared >= options.blur_radius) continue;
    double depth = 0, sum = 0;
    for (int k = 0; k < 3; ++k) {
      const double weight = std::max(0.0, w[k] / z[k]);
      sum += weight;
      depth += weight * z[k];
    }
    const double s = inside ? -squared : squared;
    hits.push_back({depth / sum, f, 1 - 1 / (1 + std::exp(s / options.sigma))});
  }
  std::sort(hits.begin(), hits.end());
  const auto most = static_cast<size_t>(options.faces_per_pixel);
  if (hits.size() > most) {
    out.margin = std::min(out.margin, hits[most].depth - hits[most - 1].depth);
    hits.resize(most);
  }
  double background = 1;
  for (const Hit& hit : hits) background *= hit.factor;
  out.value = 1 - background;
  return out;
}

}  // namespace cagefit::testing

#endif  // CAGEFIT_TESTS_CORE_IMAGE_NAIVE_SILHOUETTE_H_
