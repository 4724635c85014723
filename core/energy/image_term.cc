#include "core/energy/image_term.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "core/base/parallel.h"
#include "core/base/random.h"
#include "core/image/projected_mesh.h"

namespace cagefit {

namespace {

constexpr int64_t kVertexGrain = 2048;
// Cosine of the angle between ray and normal below which a triangle's depth is too steep to follow.
constexpr double kLeastFacing = 0.1;

// Of a camera that sees no outline: its principal point stays.
constexpr double kLeastSlope = 1e-6;

// Mixes numbers into a seed (splitmix64).
uint64_t Mix(uint64_t a, uint64_t b) {
  uint64_t x = a + 0x9e3779b97f4a7c15 * (b + 1);
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9;
  x = (x ^ (x >> 27)) * 0x94d049bb133111eb;
  return x ^ (x >> 31);
}

}  // namespace

// dr = sum_c share_c direction . dQ_c of one residual r.
struct ImageTerm::SurfaceRow {
  int32_t triangle;
  Eigen::Vector3d share;      // per corner
  Eigen::Vector3d direction;  // 3D
  double weight;              // of r^2
};

ImageTerm::ImageTerm(std::shared_ptr<const RefinedSurface> m1, const SilhouetteOptions& options,
                     int per_iteration, uint64_t seed)
    : m1_(std::move(m1)),
      edges_(m1_->topology.triangles()),
      options_(options),
      per_iteration_(per_iteration),
      seed_(seed) {}

void ImageTerm::SetTarget(const std::vector<ImageTarget>* targets, const ImageWeights& weights,
                          uint64_t frame) {
  targets_ = targets;
  weights_ = weights;
  frame_ = frame;
  is_on_ = targets != nullptr && !targets->empty() && weights.any();
  ++evaluation_;
  V_.resize(3, 0);
  views_.resize(is_on_ ? targets->size() : 0);
  for (size_t k = 0; k < views_.size(); ++k) views_[k].camera = (*targets)[k].camera;
  UseAll();
}

bool ImageTerm::draws() const {
  return is_on_ && per_iteration_ > 0 && per_iteration_ < static_cast<int>(targets_->size());
}

void ImageTerm::UseAll() {
  drawn_.resize(views_.size());
  std::iota(drawn_.begin(), drawn_.end(), 0);
}

void ImageTerm::Draw(int64_t iteration) {
  UseAll();
  if (!draws()) return;
  Random random(Mix(Mix(seed_, frame_), static_cast<uint64_t>(iteration)));
  for (int k = 0; k < per_iteration_; ++k) {
    const auto left = static_cast<double>(drawn_.size() - k);
    std::swap(drawn_[k], drawn_[k + static_cast<int>(random.Uniform() * left)]);
  }
  drawn_.resize(per_iteration_);
  std::sort(drawn_.begin(), drawn_.end());
}

double ImageTerm::Weight(const ImageTarget& target) const {
  return 2.0 / (static_cast<double>(drawn_.size()) *
                static_cast<double>(target.silhouette.pixel_count()));
}

double ImageTerm::Evaluate(const Points3d& V) {
  if (!is_on_) return 0;
  if (V_.cols() != V.cols() || V_ != V) {
    V_ = V;
    ApplyStencils(m1_->position, V, &Q_);
    ++evaluation_;
  }
  ParallelFor(static_cast<int64_t>(drawn_.size()), 1, [&](int64_t begin, int64_t end) {
    for (int64_t k = begin; k < end; ++k) {
      View& view = views_[drawn_[k]];
      if (view.evaluation == evaluation_) continue;
      view.energy = EvaluateView(drawn_[k]);
      view.evaluation = evaluation_;
    }
  });
  double sum = 0;
  for (const int32_t k : drawn_) sum += Weight((*targets_)[k]) * views_[k].energy;
  return sum;
}

double ImageTerm::EvaluateView(size_t k) {
  View& view = views_[k];
  const ImageTarget& target = (*targets_)[k];
  view.rendering.Render(
      Q_, m1_->topology.triangles(), edges_, view.camera, options_,
      weights_.depth > 0 || weights_.normals > 0 ? Surfaces::kVisible : Surfaces::kHidden);
  double sum = 0;
  if (weights_.silhouette > 0) {
    const Image& image = view.rendering.silhouette();
    if (view.residual.width != image.width || view.residual.height != image.height) {
      view.residual = Image(image.width, image.height);
    }
    for (size_t p = 0; p < image.values.size(); ++p) {
      float r = image.values[p] - target.silhouette.values[p];
      if (!target.observed.empty()) r *= target.observed.values[p];
      view.residual.values[p] = r;
      sum += double{r} * r;
    }
    sum *= weights_.silhouette;
  }
  ForSurfaceRows(k, [&](const SurfaceRow& row, double r) { sum += row.weight * r * r; });
  return sum;
}

void ImageTerm::Calibrate(const Points3d& V) {
  if (!is_on_ || weights_.silhouette <= 0 || options_.mode != SilhouetteMode::kOutline) return;
  Evaluate(V);
  ParallelFor(static_cast<int64_t>(drawn_.size()), 1, [&](int64_t begin, int64_t end) {
    for (int64_t k = begin; k < end; ++k) {
      if ((*targets_)[drawn_[k]].slack > 0) CalibrateView(drawn_[k]);
    }
  });
}

// With the principal point c, dA/dc at a pixel is the sum of by_point over its rows: all edges move
// alike.
void ImageTerm::CalibrateView(size_t k) {
  View& view = views_[k];
  const ImageTarget& target = (*targets_)[k];
  view.slopes.assign(target.silhouette.values.size(), Eigen::Vector2d::Zero());
  for (const OutlineSilhouette::Row& row : view.rendering.outline().rows()) {
    view.slopes[row.pixel] += row.by_point;
  }
  Eigen::Vector2d g = Eigen::Vector2d::Zero();
  Eigen::Matrix2d H = kLeastSlope * Eigen::Matrix2d::Identity();
  for (size_t p = 0; p < view.slopes.size(); ++p) {
    const Eigen::Vector2d& slope = view.slopes[p];
    if (slope.isZero(0) || (!target.observed.empty() && target.observed.values[p] == 0)) continue;
    g += double{view.residual.values[p]} * slope;
    H += slope * slope.transpose();
  }
  const Eigen::Vector2d from(view.camera.cx, view.camera.cy),
      stated(target.camera.cx, target.camera.cy);
  Eigen::Vector2d offset = from - H.inverse() * g - stated;
  if (offset.norm() > target.slack) offset *= target.slack / offset.norm();
  const auto evaluate_at = [&](const Eigen::Vector2d& c) {
    view.camera.cx = c.x();
    view.camera.cy = c.y();
    return EvaluateView(k);
  };
  const double before = view.energy;
  view.energy = evaluate_at(stated + offset);
  if (!(view.energy < before)) view.energy = evaluate_at(from);
}

template <typename Body>
void ImageTerm::ForSurfaceRows(size_t k, const Body& body) const {
  const ImageTarget& target = (*targets_)[k];
  const bool has_depth = weights_.depth > 0 && !target.depth.empty();
  const bool has_normals = weights_.normals > 0 && !target.normals.empty();
  if (!has_depth && !has_normals) return;
  const DepthBuffer& depths = views_[k].rendering.depths();
  const Camera& camera = views_[k].camera;
  const Eigen::Vector3d eye = camera.center();
  const Triangles& triangles = m1_->topology.triangles();
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      const int32_t f = depths.triangle(x, y);
      if (f == DepthBuffer::kNone) continue;
      const Eigen::Vector3d a = Q_.col(triangles(0, f)), ab = Q_.col(triangles(1, f)) - a,
                            ac = Q_.col(triangles(2, f)) - a;
      const Eigen::Vector3d cross = ab.cross(ac);
      const double area = cross.norm();
      if (!(area > 0)) continue;
      Eigen::Vector3d n = cross / area;
      const Eigen::Vector3d ray =
          camera.R.transpose() *
          Eigen::Vector3d((x - camera.cx) / camera.fx, (y - camera.cy) / camera.fy, 1);
      const double facing = n.dot(ray), depth = depths.depth(x, y);
      if (!(std::abs(facing) > kLeastFacing * ray.norm())) continue;
      const double wanted = target.depth.empty() ? 0 : *target.depth.at(x, y);
      if (has_depth && wanted > 0) {
        const double r = depth - wanted;
        if (std::abs(r) <= kDepthReach) {
          const Eigen::Vector3d hit = eye + depth * ray - a;
          const double b1 = hit.cross(ac).dot(cross) / (area * area),
                       b2 = ab.cross(hit).dot(cross) / (area * area);
          body(SurfaceRow{f, {1 - b1 - b2, b1, b2}, n / facing, weights_.depth}, r);
        }
      }
      if (!has_normals || (wanted > 0 && std::abs(depth - wanted) > kDepthReach)) continue;
      const float* normal = target.normals.at(x, y);
      const Eigen::Vector3d to(normal[0], normal[1], normal[2]);
      if (to.squaredNorm() < 0.5) continue;
      // Gradients of the barycentric weights, in the triangle's plane.
      const Eigen::Vector3d g1 = ac.cross(cross) / (area * area),
                            g2 = cross.cross(ab) / (area * area);
      const double turn = facing > 0 ? -1 : 1;  // towards the camera
      for (int c = 0; c < 3; ++c) {
        body(SurfaceRow{f, -turn * Eigen::Vector3d(-g1[c] - g2[c], g1[c], g2[c]), n,
                        weights_.normals},
             turn * n[c] - to[c]);
      }
    }
  }
}

void ImageTerm::AddHalfGradient(Points3d* half_gradient) {
  if (!is_on_) return;
  const int64_t m = m1_->position.rows();
  ParallelFor(static_cast<int64_t>(drawn_.size()), 1, [&](int64_t begin, int64_t end) {
    for (int64_t i = begin; i < end; ++i) {
      const int32_t k = drawn_[i];
      View& view = views_[k];
      view.gradient.setZero(3, m);
      if (weights_.silhouette > 0) {
        view.rendering.AddGradient(view.residual, &view.gradient);
        view.gradient *= weights_.silhouette;
      }
      ForSurfaceRows(k, [&](const SurfaceRow& row, double r) {
        for (int c = 0; c < 3; ++c) {
          view.gradient.col(m1_->topology.triangles()(c, row.triangle)) +=
              row.weight * r * row.share[c] * row.direction;
        }
      });
    }
  });
  pull_.setZero(3, m);
  ParallelFor(m, kVertexGrain, [&](int64_t begin, int64_t end) {
    for (const int32_t k : drawn_) {
      pull_.middleCols(begin, end - begin) +=
          Weight((*targets_)[k]) * views_[k].gradient.middleCols(begin, end - begin);
    }
  });
  ParallelFor(half_gradient->cols(), kVertexGrain, [&](int64_t begin, int64_t end) {
    for (int64_t j = begin; j < end; ++j) {
      Eigen::Vector3d g = Eigen::Vector3d::Zero();
      for (StencilMatrix::InnerIterator s(m1_->transposed, j); s; ++s) {
        g += s.value() * pull_.col(s.col());
      }
      half_gradient->col(j) += g;
    }
  });
}

void ImageTerm::AddBlocks(SurfaceBlocks* blocks) const {
  if (!is_on_) return;
  const Topology& m1 = m1_->topology;
  for (const int32_t k : drawn_) {
    const View& view = views_[k];
    const ImageTarget& target = (*targets_)[k];
    const double weight = Weight(target);
    const bool has_rows = weights_.silhouette > 0 && options_.mode == SilhouetteMode::kOutline;
    if (has_rows) {
      for (const OutlineSilhouette::Row& row : view.rendering.outline().rows()) {
        const bool is_hidden = !target.observed.empty() && target.observed.values[row.pixel] == 0;
        if (is_hidden) continue;
        const auto& [a, b] = edges_.vertices(row.edge);
        const Eigen::Vector3d at = (1 - row.t) * Q_.col(a) + row.t * Q_.col(b);
        const Eigen::Vector3f d =
            (ProjectionJacobian(view.camera, at).transpose() * row.by_point).cast<float>();
        const Eigen::Matrix3f D =
            static_cast<float>(weight * weights_.silhouette * row.share) * d * d.transpose();
        const auto t = static_cast<float>(row.t);
        blocks->vertex[a] += (1 - t) * (1 - t) * D;
        blocks->vertex[b] += t * t * D;
        blocks->lumped[a] += (1 - t) * D;
        blocks->lumped[b] += t * D;
        blocks->edge[row.edge] += t * (1 - t) * D;
      }
    }
    ForSurfaceRows(k, [&](const SurfaceRow& row, double) {
      const Eigen::Vector3f d = row.direction.cast<float>(), b = row.share.cast<float>();
      const Eigen::Matrix3f D = static_cast<float>(weight * row.weight) * d * d.transpose();
      for (int c = 0; c < 3; ++c) {
        const int32_t v = m1.triangles()(c, row.triangle);
        blocks->vertex[v] += b[c] * b[c] * D;
        // Of normals, whose shares sum to 0, no vertex moves with the others.
        blocks->lumped[v] += std::max(b[c] * b.sum(), b[c] * b[c]) * D;
        blocks->edge[m1.triangle_edge(row.triangle, c)] += b[c] * b[(c + 1) % 3] * D;
      }
    });
  }
}

}  // namespace cagefit
