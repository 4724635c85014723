#include "core/image/point_surface.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "core/base/parallel.h"

namespace cagefit {

namespace {

constexpr float kLeastFacing = 0.1f;  // cosine between the normal and the line of sight
constexpr float kFewestPoints = 3;
constexpr int kLanes = 4;
constexpr float kOutOfReach = 1e9f;
constexpr int64_t kGrain = 8192, kRowGrain = 8;

// Positive floats are in the order of their bits, so that the least key is the nearest point, the
// lowest index of equally near ones.
constexpr uint64_t kNone = ~uint64_t{0};
uint64_t KeyOf(float depth, int32_t index) {
  uint32_t bits;
  std::memcpy(&bits, &depth, sizeof(bits));
  return static_cast<uint64_t>(bits) << 32 | static_cast<uint32_t>(index);
}

// Pixels; the largest one bounds the work where the camera is close to the points.
float RadiusAt(float depth, float focal_length, float tolerance) {
  return std::clamp(focal_length * tolerance / depth, 1.0f, 32.0f);
}

// Largest distance in the image, in radii, of the mean of n points from the pixel that they stand
// for. The mean of a sheet that ends at the pixel is 0.3 away, of one around it by chance sqrt(n)
// times less than 0.3 in each direction.
float MostOffCentre(float n) { return 0.25f + 0.5f / std::sqrt(n); }

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
  for (std::vector<float>& field : points_) field.resize(pixels_.size() + kLanes);
  for (int lane = 0; lane < kLanes; ++lane) points_[kU][pixels_.size() + lane] = kOutOfReach;
  const Eigen::Matrix3f R = camera.R.cast<float>();
  const Eigen::Vector3f t = camera.t.cast<float>();
  ParallelFor(pixels_.size(), kGrain, [&](int64_t begin, int64_t end) {
    for (int64_t k = begin; k < end; ++k) {
      const int32_t i = pixels_.source(static_cast<int32_t>(k));
      const Eigen::Vector3f n = R * cloud.normals.col(i), p = R * cloud.points.col(i) + t;
      points_[kU][k] = u[i] - static_cast<float>(window.x);
      points_[kV][k] = v[i] - static_cast<float>(window.y);
      for (int axis = 0; axis < 3; ++axis) {
        points_[kX + axis][k] = p[axis];
        points_[kNx + axis][k] = n[axis];
      }
      points_[kPlane][k] = n.dot(p);
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
          own[x] = std::min(own[x], KeyOf(points_[kZ][k], k));
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
bool PointSurface::FitPixel(int x, int y, float focal_length, float tolerance,
                            const Eigen::Vector3f& ray, float* depth,
                            Eigen::Vector3f* normal) const {
  const uint64_t key = nearest_[static_cast<int64_t>(y) * pixels_.width() + x];
  if (key == kNone) return false;
  const auto nearest = static_cast<uint32_t>(key);
  using Lanes = Eigen::Array<float, kLanes, 1>;
  const auto lanes = [&](int field, int32_t k) -> Lanes {
    return Eigen::Map<const Lanes>(&points_[field][k]);
  };
  const float front_x = points_[kNx][nearest], front_y = points_[kNy][nearest];
  const float front_z = points_[kNz][nearest], front_plane = points_[kPlane][nearest];
  const auto u = static_cast<float>(x), v = static_cast<float>(y);
  const float radius = RadiusAt(points_[kZ][nearest], focal_length, tolerance);
  const float inverse_radius2 = 1 / (radius * radius);
  const float inverse_tolerance2 = 1 / (tolerance * tolerance);
  Lanes w_sum = Lanes::Zero(), w2_sum = w_sum;
  std::array<Lanes, kFields> sums;
  sums.fill(w_sum);
  const int span = static_cast<int>(radius + 0.5f);
  for (int row = std::max(0, y - span); row <= std::min(pixels_.height() - 1, y + span); ++row) {
    // Points of this row of pixels are at least `gap` rows away.
    const float gap = std::max(0.0f, static_cast<float>(std::abs(row - y)) - 0.5f);
    const int half =
        static_cast<int>(std::sqrt(std::max(0.0f, radius * radius - gap * gap)) + 0.5f);
    // The last lanes may hold points behind the run: they are out of reach, and weigh nothing.
    const int32_t end = pixels_.begin(std::min(pixels_.width() - 1, x + half) + 1, row);
    for (int32_t k = pixels_.begin(std::max(0, x - half), row); k < end; k += kLanes) {
      const Lanes du = lanes(kU, k) - u, dv = lanes(kV, k) - v;
      const Lanes height =
          front_x * lanes(kX, k) + front_y * lanes(kY, k) + front_z * lanes(kZ, k) - front_plane;
      const Lanes closeness = (1 - inverse_radius2 * (du * du + dv * dv)).max(0.0f);
      const Lanes on_sheet = (1 - inverse_tolerance2 * height * height).max(0.0f);
      const Lanes w = closeness * closeness * on_sheet;
      w_sum += w;
      w2_sum += w * w;
      sums[kU] += w * du;
      sums[kV] += w * dv;
      for (int field = kX; field < kFields; ++field) sums[field] += w * lanes(field, k);
    }
  }
  // As many points of equal weight would scatter as much.
  const float weight = w_sum.sum(), points = weight * weight / w2_sum.sum();
  if (!(points >= kFewestPoints)) return false;
  const Eigen::Vector2f offset(sums[kU].sum(), sums[kV].sum());
  if (offset.norm() > MostOffCentre(points) * radius * weight) return false;
  const Eigen::Vector3f position(sums[kX].sum(), sums[kY].sum(), sums[kZ].sum());
  const Eigen::Vector3f sum(sums[kNx].sum(), sums[kNy].sum(), sums[kNz].sum());
  const Eigen::Vector3f n = sum.normalized();
  const float facing = -n.dot(ray);
  if (!(facing > kLeastFacing * ray.norm())) return false;
  *depth = (sums[kPlane].sum() + n.dot(position)) / (sum.dot(ray) - facing * weight);
  *normal = n;
  return *depth > 0;
}

void PointSurface::Build(const PointCloud& cloud, const Camera& camera, const std::vector<float>& u,
                         const std::vector<float>& v, const Image& inside,
                         const PixelWindow& window, double tolerance, double typical_depth,
                         Image* depth, Image* normals) {
  const auto focal_length = static_cast<float>(std::sqrt(camera.fx * camera.fy));
  const auto limit = static_cast<float>(tolerance);
  const int span =
      static_cast<int>(std::ceil(RadiusAt(static_cast<float>(typical_depth), focal_length, limit)));
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
        if (!FitPixel(x - grown.x, y - grown.y, focal_length, limit, ray.cast<float>(), &z,
                      &normal)) {
          continue;
        }
        *depth->at(x, y) = z;
        Eigen::Map<Eigen::Vector3f>(normals->at(x, y)) = to_world * normal;
      }
    }
  });
}

}  // namespace cagefit
