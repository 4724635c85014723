#include "core/image/point_surface.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "core/base/parallel.h"

namespace cagefit {

namespace {

constexpr float kLeastFacing = 0.1f;  // cosine between the normal and the line of sight
constexpr int kFewestPoints = 4;
// Distance of the weighted mean of the points in the image from the pixel, in radii. For a sheet
// that ends at the pixel it is 0.3; by chance it reaches 0.35 for one pixel in several hundred.
constexpr float kMostOffCentre = 0.35f;
constexpr int64_t kGrain = 8192, kRowGrain = 8;

// Positive floats are in the order of their bits, so that the least key is the nearest point, the
// lowest index of equally near ones.
constexpr uint64_t kNone = ~uint64_t{0};
uint64_t KeyOf(float depth, int32_t index) {
  uint32_t bits;
  std::memcpy(&bits, &depth, sizeof(bits));
  return static_cast<uint64_t>(bits) << 32 | static_cast<uint32_t>(index);
}

}  // namespace

void PointSurface::SortFacing(const PointCloud& cloud, const Camera& camera,
                              const std::vector<float>& u, const std::vector<float>& v,
                              const PixelWindow& window) {
  const int64_t count = cloud.size();
  const Eigen::Vector3f center = camera.center().cast<float>();
  facing_u_.resize(count);
  ParallelFor(count, kGrain, [&](int64_t begin, int64_t end) {
    for (int64_t i = begin; i < end; ++i) {
      const Eigen::Vector3f sight = cloud.points.col(i) - center;
      const float along = sight.dot(cloud.normals.col(i));
      const bool faces =
          along < 0 && along * along > kLeastFacing * kLeastFacing * sight.squaredNorm();
      facing_u_[i] = faces ? u[i] : std::numeric_limits<float>::quiet_NaN();
    }
  });
  pixels_.Build(facing_u_, v, window, 1);
  points_.resize(pixels_.size());
  const Eigen::Matrix3f R = camera.R.cast<float>();
  const Eigen::Vector3f t = camera.t.cast<float>();
  ParallelFor(pixels_.size(), kGrain, [&](int64_t begin, int64_t end) {
    for (int64_t k = begin; k < end; ++k) {
      const int32_t i = pixels_.source(static_cast<int32_t>(k));
      const Eigen::Vector3f n = R * cloud.normals.col(i), p = R * cloud.points.col(i) + t;
      points_[k].normal << n[0], n[1], n[2], 1.0f;
      points_[k].position << p[0], p[1], p[2], n.dot(p);
      points_[k].u = u[i] - static_cast<float>(window.x);
      points_[k].v = v[i] - static_cast<float>(window.y);
    }
  });
}

// The nearest point in the square of pixels that reaches `span` to each side: along the rows
// first, then across them.
void PointSurface::FindNearest(int span) {
  const int width = pixels_.width(), height = pixels_.height();
  nearest_in_row_.resize(static_cast<size_t>(width) * height);
  nearest_.resize(nearest_in_row_.size());
  ParallelFor(height, kRowGrain, [&](int64_t begin, int64_t end) {
    for (int64_t y = begin; y < end; ++y) {
      uint64_t* const own = &nearest_[y * width];
      for (int x = 0; x < width; ++x) {
        own[x] = kNone;
        const int row = static_cast<int>(y);
        for (int32_t k = pixels_.begin(x, row); k < pixels_.begin(x + 1, row); ++k) {
          own[x] = std::min(own[x], KeyOf(points_[k].position[2], k));
        }
      }
      for (int x = 0; x < width; ++x) {
        const int first = std::max(0, x - span), last = std::min(width - 1, x + span);
        nearest_in_row_[y * width + x] = *std::min_element(own + first, own + last + 1);
      }
    }
  });
  ParallelFor(height, kRowGrain, [&](int64_t begin, int64_t end) {
    for (int64_t y = begin; y < end; ++y) {
      uint64_t* const out = &nearest_[y * width];
      std::fill(out, out + width, kNone);
      const int64_t last = std::min<int64_t>(height - 1, y + span);
      for (int64_t row = std::max<int64_t>(0, y - span); row <= last; ++row) {
        const uint64_t* const in = &nearest_in_row_[row * width];
        for (int x = 0; x < width; ++x) out[x] = std::min(out[x], in[x]);
      }
    }
  });
}

// Depth and normal, in camera axes, where the ray of pixel (x, y) of the window meets the surface.
bool PointSurface::FitPixel(int x, int y, float radius, float tolerance, const Eigen::Vector3f& ray,
                            float* depth, Eigen::Vector3f* normal) const {
  const uint64_t key = nearest_[static_cast<int64_t>(y) * pixels_.width() + x];
  if (key == kNone) return false;
  const auto nearest = static_cast<uint32_t>(key);
  const Eigen::Array4f front = points_[nearest].normal, front_position = points_[nearest].position;
  const auto u = static_cast<float>(x), v = static_cast<float>(y);
  const float inverse_radius2 = 1 / (radius * radius);
  Eigen::Array4f normals = Eigen::Array4f::Zero(), positions = normals;
  Eigen::Vector2f offsets = Eigen::Vector2f::Zero();
  int count = 0;
  const int span = static_cast<int>(radius + 0.5f);
  for (int row = std::max(0, y - span); row <= std::min(pixels_.height() - 1, y + span); ++row) {
    // Points of this row of pixels are at least `gap` rows away.
    const float gap = std::max(0.0f, static_cast<float>(std::abs(row - y)) - 0.5f);
    const int half =
        static_cast<int>(std::sqrt(std::max(0.0f, radius * radius - gap * gap)) + 0.5f);
    const int32_t begin = pixels_.begin(std::max(0, x - half), row);
    const int32_t end = pixels_.begin(std::min(pixels_.width() - 1, x + half) + 1, row);
    for (int32_t k = begin; k < end; ++k) {
      const SurfacePoint& point = points_[k];
      const float du = point.u - u, dv = point.v - v;
      const float closeness = 1 - inverse_radius2 * (du * du + dv * dv);
      const float height = front[0] * point.position[0] + front[1] * point.position[1] +
                           front[2] * point.position[2] - front_position[3];
      // No branch: which points count is as good as random.
      const float kept = std::max(0.0f, std::abs(height) <= tolerance ? closeness : 0.0f);
      const float w = kept * kept;
      normals += w * point.normal;
      positions += w * point.position;
      offsets += w * Eigen::Vector2f(du, dv);
      count += kept > 0 ? 1 : 0;
    }
  }
  const float weight = normals[3];
  if (count < kFewestPoints || offsets.norm() > kMostOffCentre * radius * weight) {
    return false;
  }
  const Eigen::Vector3f sum = normals.matrix().head<3>(), n = sum.normalized();
  const float facing = -n.dot(ray);
  if (!(facing > kLeastFacing * ray.norm())) return false;
  *depth = (positions[3] + n.dot(positions.matrix().head<3>())) / (sum.dot(ray) - facing * weight);
  *normal = n;
  return *depth > 0;
}

void PointSurface::Build(const PointCloud& cloud, const Camera& camera, const std::vector<float>& u,
                         const std::vector<float>& v, const Image& inside,
                         const PixelWindow& window, double radius, double tolerance, Image* depth,
                         Image* normals) {
  const int span = static_cast<int>(std::ceil(radius));
  const int x0 = std::max(0, window.x), x1 = std::min(camera.width, window.x + window.width);
  const int y0 = std::max(0, window.y), y1 = std::min(camera.height, window.y + window.height);
  *depth = Image(camera.width, camera.height);
  *normals = Image(camera.width, camera.height, 3);
  if (x0 >= x1 || y0 >= y1) return;
  const PixelWindow grown{x0 - span, y0 - span, x1 - x0 + 2 * span, y1 - y0 + 2 * span};
  SortFacing(cloud, camera, u, v, grown);
  FindNearest(span);
  const Eigen::Matrix3f to_world = camera.R.transpose().cast<float>();
  ParallelFor(y1 - y0, kRowGrain, [&](int64_t begin, int64_t end) {
    for (int y = y0 + static_cast<int>(begin); y < y0 + static_cast<int>(end); ++y) {
      for (int x = x0; x < x1; ++x) {
        if (*inside.at(x, y) < 0.5f) continue;
        const Eigen::Vector3d ray((x - camera.cx) / camera.fx, (y - camera.cy) / camera.fy, 1);
        Eigen::Vector3f normal;
        float z = 0;
        if (!FitPixel(x - grown.x, y - grown.y, static_cast<float>(radius),
                      static_cast<float>(tolerance), ray.cast<float>(), &z, &normal)) {
          continue;
        }
        *depth->at(x, y) = z;
        Eigen::Map<Eigen::Vector3f>(normals->at(x, y)) = to_world * normal;
      }
    }
  });
}

}  // namespace cagefit
