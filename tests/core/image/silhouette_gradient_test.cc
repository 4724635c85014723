// dE/dV of E = sum_p weight_p A_p against finite differences, with everything that decides on a
// pixel (which triangle, which edge) held.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "core/image/mesh_renderer.h"
#include "tests/core/image/naive_silhouette.h"
#include "tests/core/image/scenes.h"

namespace cagefit {
namespace {

using testing::Icosphere;
using testing::NaivePixel;
using testing::NaiveSilhouette;
using testing::TestCamera;
using testing::Together;
using testing::Torus;
using testing::TriangleSoup;
using testing::WideCamera;

// Smooth: neighbouring pixels that cancel each other would leave rounding alone.
Image Weights(const Camera& camera, uint64_t seed) {
  Random random(seed);
  const Eigen::Vector3d f = random.NormalVector();
  Image out(camera.width, camera.height);
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      *out.at(x, y) =
          static_cast<float>(std::cos(3 * (f[0] * x + f[1] * y) / camera.half_side() + f[2]));
    }
  }
  return out;
}

// Which of the mesh's vertices can be seen to move anything.
std::vector<int32_t> MovingVertices(const Points3d& gradient) {
  std::vector<int32_t> out;
  const double most = gradient.colwise().norm().maxCoeff();
  for (int32_t v = 0; v < gradient.cols(); ++v) {
    if (gradient.col(v).norm() > 1e-3 * most) out.push_back(v);
  }
  return out;
}

struct Comparison {
  int vertices = 0, pixels = 0, left_out = 0;
  double worst = 0;  // relative
};

// What each pixel's value hangs on: whether it is covered, and its edges.
std::vector<std::array<int32_t, 3>> Decisions(const MeshView& view) {
  std::vector<std::array<int32_t, 3>> out(view.silhouette().pixel_count(), {-1, -1, -1});
  for (const OutlineSilhouette::Row& row : view.outline().rows()) {
    auto& [covered, first, second] = out[row.pixel];
    covered = view.outline().IsInside(row.pixel);
    (first < 0 ? first : second) = row.edge;
  }
  return out;
}

// A in double precision: the image's would leave too little of a small difference.
double Value(const MeshView& view, const Camera& camera, int32_t pixel) {
  const double d = view.outline().distance().distance[pixel] / camera.half_side();
  const bool inside = view.outline().IsInside(pixel);
  const double A = 1 / (1 + std::exp((inside ? -d : d) * d / SoftSilhouetteOptions().sigma));
  if (view.outline().distance().segment[pixel] >= 0) {
    EXPECT_NEAR(A, view.silhouette().values[pixel], 1e-7);
  }
  return A;
}

void CheckOutline(const TriangleMesh& mesh, const Camera& camera, int most_vertices,
                  Comparison* out) {
  constexpr double kStep = 1e-5;
  const MeshEdges edges(mesh.triangles);
  MeshView view;
  view.Render(mesh.vertices, mesh.triangles, edges, camera, {});
  Points3d gradient = Points3d::Zero(3, mesh.vertices.cols());
  view.AddGradient(Weights(camera, 1), &gradient);
  const auto decisions = Decisions(view);
  Random random(5);
  std::vector<int32_t> vertices = MovingVertices(gradient);
  for (int k = 0; k < most_vertices && k < static_cast<int>(vertices.size()); ++k) {
    const auto left = static_cast<double>(vertices.size() - k);
    std::swap(vertices[k], vertices[k + static_cast<int>(random.Uniform() * left)]);
    const int32_t v = vertices[k];
    const Eigen::Vector3d direction = random.NormalVector().normalized();
    MeshView moved[2];
    std::vector<std::array<int32_t, 3>> decided[2];
    for (int step = 0; step < 2; ++step) {
      Points3d V = mesh.vertices;
      V.col(v) += (step == 0 ? -kStep : kStep) * direction;
      moved[step].Render(V, mesh.triangles, edges, camera, {});
      decided[step] = Decisions(moved[step]);
    }
    Image weights = Weights(camera, 1);
    double slope = 0;
    for (int32_t p = 0; p < static_cast<int32_t>(weights.values.size()); ++p) {
      const double change = Value(moved[1], camera, p) - Value(moved[0], camera, p);
      const bool is_held = std::all_of(std::begin(decided), std::end(decided),
                                       [&](const auto& d) { return d[p] == decisions[p]; });
      if (!is_held) {
        weights.values[p] = 0;
        ++out->left_out;
      } else if (change != 0) {
        ++out->pixels;
      }
      slope += weights.values[p] * change / (2 * kStep);
    }
    Points3d held = Points3d::Zero(3, mesh.vertices.cols());
    view.AddGradient(weights, &held);
    const double scale = std::max(held.col(v).norm(), 0.05 * gradient.colwise().norm().maxCoeff());
    out->worst = std::max(out->worst, std::abs(held.col(v).dot(direction) - slope) / scale);
    ++out->vertices;
  }
}

TEST(SilhouetteGradientTest, OutlineModePassesFiniteDifferences) {
  Comparison all;
  TriangleMesh bumpy = Icosphere(3);
  Random random(3);
  for (int64_t v = 0; v < bumpy.vertices.cols(); ++v) {
    bumpy.vertices.col(v) += 0.02 * random.NormalVector();
  }
  CheckOutline(Icosphere(4), TestCamera(64), 150, &all);
  CheckOutline(bumpy, WideCamera(), 200, &all);
  CheckOutline(bumpy, TestCamera(64, 1.9), 100, &all);  // leaves the image on all sides
  CheckOutline(Torus(48, 24), TestCamera(64), 150, &all);
  TriangleMesh other = Torus(24, 12, 0.7, 0.4);
  other.vertices.row(0).array() += 0.5;
  CheckOutline(Together(bumpy, other), WideCamera(), 150, &all);  // outlines that cross
  for (const uint64_t seed : {1, 2, 3, 4, 5}) {
    CheckOutline(TriangleSoup(60, 0.6, seed), WideCamera(), 120, &all);
  }
  CheckOutline(TriangleSoup(150, 0.2, 6), TestCamera(64), 200, &all);
  EXPECT_GE(all.vertices, 1000);
  EXPECT_LT(all.left_out, 0.1 * all.pixels);
  EXPECT_LT(all.worst, 1e-4);
}

// The formula's energy over the pixels that a vertex may reach, and triangles near them only.
class NaiveEnergy {
 public:
  NaiveEnergy(const TriangleMesh& mesh, const Camera& camera, const SoftSilhouetteOptions& options)
      : mesh_(mesh), camera_(camera), options_(options), weights_(Weights(camera, 1)) {
    margin_ = std::sqrt(options.blur_radius) * camera.half_side() + 1;
    boxes_.resize(4, mesh.triangles.cols());
    for (int64_t f = 0; f < mesh.triangles.cols(); ++f) {
      Eigen::Vector2d low = Eigen::Vector2d::Constant(1e9), high = -low;
      for (int k = 0; k < 3; ++k) {
        const Eigen::Vector2d p = camera.Project(mesh.vertices.col(mesh.triangles(k, f))).head<2>();
        low = low.cwiseMin(p);
        high = high.cwiseMax(p);
      }
      boxes_.col(f) << low.array() - margin_, high.array() + margin_;
    }
  }

  // dE/d(direction) of vertex v; pixels whose set of triangles is about to change are left out, and
  // their weights set to 0 in `weights`.
  double Differentiate(int32_t v, const Eigen::Vector3d& direction, Image* weights) const {
    Eigen::Array4d box(1e9, 1e9, -1e9, -1e9);
    for (int64_t f = 0; f < mesh_.triangles.cols(); ++f) {
      if ((mesh_.triangles.col(f).array() != v).all()) continue;
      box.head<2>() = box.head<2>().min(boxes_.col(f).head<2>().array());
      box.tail<2>() = box.tail<2>().max(boxes_.col(f).tail<2>().array());
    }
    TriangleMesh near{mesh_.vertices, Triangles(3, mesh_.triangles.cols())};
    int64_t count = 0;
    for (int64_t f = 0; f < mesh_.triangles.cols(); ++f) {
      const auto b = boxes_.col(f);
      if (b[0] > box[2] || b[2] < box[0] || b[1] > box[3] || b[3] < box[1]) continue;
      near.triangles.col(count++) = mesh_.triangles.col(f);
    }
    near.triangles.conservativeResize(3, count);
    double sum = 0;
    constexpr double kStep = 1e-6;
    for (int y = std::max(0.0, box[1]); y <= std::min(box[3], camera_.height - 1.0); ++y) {
      for (int x = std::max(0.0, box[0]); x <= std::min(box[2], camera_.width - 1.0); ++x) {
        if (NaiveSilhouette(near, camera_, options_, x, y).margin < 2e-5) {
          *weights->at(x, y) = 0;
          continue;
        }
        near.vertices.col(v) = mesh_.vertices.col(v) + kStep * direction;
        const double above = NaiveSilhouette(near, camera_, options_, x, y).value;
        near.vertices.col(v) = mesh_.vertices.col(v) - kStep * direction;
        const double below = NaiveSilhouette(near, camera_, options_, x, y).value;
        near.vertices.col(v) = mesh_.vertices.col(v);
        sum += *weights_.at(x, y) * (above - below) / (2 * kStep);
      }
    }
    return sum;
  }

 private:
  TriangleMesh mesh_;
  Camera camera_;
  SoftSilhouetteOptions options_;
  Image weights_;
  double margin_;
  Eigen::Matrix<double, 4, Eigen::Dynamic> boxes_;
};

void CheckSoft(const TriangleMesh& mesh, const Camera& camera, const SoftSilhouetteOptions& options,
               int most_vertices, Comparison* out) {
  const MeshEdges edges(mesh.triangles);
  MeshView view;
  view.Render(mesh.vertices, mesh.triangles, edges, camera, {SilhouetteMode::kPytorch3d, options});
  Points3d gradient = Points3d::Zero(3, mesh.vertices.cols());
  view.AddGradient(Weights(camera, 1), &gradient);
  const NaiveEnergy naive(mesh, camera, options);
  Random random(6);
  std::vector<int32_t> vertices = MovingVertices(gradient);
  for (int k = 0; k < most_vertices && k < static_cast<int>(vertices.size()); ++k) {
    std::swap(vertices[k],
              vertices[k + static_cast<int>(random.Uniform() *
                                            static_cast<double>(vertices.size() - k))]);
    const int32_t v = vertices[k];
    const Eigen::Vector3d direction = random.NormalVector().normalized();
    Image weights = Weights(camera, 1);
    const double expected = naive.Differentiate(v, direction, &weights);
    Points3d held = Points3d::Zero(3, mesh.vertices.cols());
    view.AddGradient(weights, &held);
    const double scale = std::max(held.col(v).norm(), 0.05 * gradient.colwise().norm().maxCoeff());
    out->worst = std::max(out->worst, std::abs(held.col(v).dot(direction) - expected) / scale);
    ++out->vertices;
  }
}

TEST(SilhouetteGradientTest, Pytorch3dModePassesFiniteDifferences) {
  Comparison all;
  CheckSoft(Icosphere(3), TestCamera(64), {}, 250, &all);
  CheckSoft(Icosphere(2), WideCamera(), {}, 100, &all);
  CheckSoft(Torus(24, 12), TestCamera(64, 1.6), {}, 150, &all);  // leaves the image on all sides
  SoftSilhouetteOptions few;
  few.faces_per_pixel = 4;
  CheckSoft(Icosphere(3), TestCamera(64), few, 150, &all);
  for (const uint64_t seed : {1, 2, 3}) {
    CheckSoft(TriangleSoup(60, 0.5, seed), WideCamera(), {}, 120, &all);
  }
  EXPECT_GE(all.vertices, 1000);
  EXPECT_LT(all.worst, 1e-4);
}

}  // namespace
}  // namespace cagefit
