#include "core/image/point_outline.h"

#include <algorithm>
#include <cmath>

#include "core/base/parallel.h"
#include "core/image/marching_squares.h"

namespace cagefit {

namespace {

constexpr int kNodesPerPixel = 2;
constexpr int64_t kRowGrain = 8;
constexpr float kFar = 1e9f;
// From the centre of an occupied cell to the point in it, in nodes: half a diagonal at most.
constexpr float kCellError = 0.70711f;

}  // namespace

int PointOutline::Margin(const ClosingRadii& radii) {
  return static_cast<int>(std::ceil(radii.radius + radii.hole_radius)) + 3;
}

// The window is the part of the image with its margin where points are, and around it a margin of
// its own in which the background is sure.
void PointOutline::Sort(const std::vector<float>& u, const std::vector<float>& v, int width,
                        int height, int margin) {
  const auto low = static_cast<float>(-margin);
  const auto right = static_cast<float>(width - 1 + margin);
  const auto bottom = static_cast<float>(height - 1 + margin);
  float x0 = right, x1 = low, y0 = bottom, y1 = low;
  for (size_t i = 0; i < u.size(); ++i) {
    if (!(u[i] >= low && v[i] >= low && u[i] <= right && v[i] <= bottom)) continue;
    x0 = std::min(x0, u[i]);
    x1 = std::max(x1, u[i]);
    y0 = std::min(y0, v[i]);
    y1 = std::max(y1, v[i]);
  }
  window_ = PixelWindow();
  if (x0 <= x1 && y0 <= y1) {
    window_.x = static_cast<int>(std::floor(x0)) - margin;
    window_.y = static_cast<int>(std::floor(y0)) - margin;
    window_.width = static_cast<int>(std::ceil(x1)) + margin + 1 - window_.x;
    window_.height = static_cast<int>(std::ceil(y1)) + margin + 1 - window_.y;
  }
  cells_.Build(u, v, window_, kNodesPerPixel);
  sorted_x_.resize(cells_.size());
  sorted_y_.resize(cells_.size());
  for (int32_t i = 0; i < cells_.size(); ++i) {
    const int32_t k = cells_.source(i);
    sorted_x_[i] = kNodesPerPixel * (u[k] - static_cast<float>(window_.x));
    sorted_y_[i] = kNodesPerPixel * (v[k] - static_cast<float>(window_.y));
  }
}

// D at the nodes to kCellError: the distance to the nearest occupied cell's centre, as far as
// `reach`, large beyond. Down the columns first, then along the rows [felzenszwalb2012]; trying all
// columns within a short reach is faster than their lower envelope.
void PointOutline::MeasureCells(double reach) {
  const int width = cells_.width(), height = cells_.height();
  const int span = static_cast<int>(std::ceil(reach));
  const int64_t stride = width + 2 * span;
  column_.assign(stride * height, kFar);
  for (int y = 0; y < height; ++y) {
    float* const row = &column_[y * stride + span];
    for (int x = 0; x < width; ++x) {
      if (cells_.begin(x, y) < cells_.begin(x + 1, y)) {
        row[x] = 0;
      } else if (y > 0) {
        row[x] = row[x - stride] + 1;
      }
    }
  }
  for (int y = height - 2; y >= 0; --y) {
    float* const row = &column_[y * stride + span];
    for (int x = 0; x < width; ++x) row[x] = std::min(row[x], row[x + stride] + 1);
  }
  nodes_.width = width;
  nodes_.height = height;
  nodes_.values.resize(static_cast<size_t>(width) * height);
  ParallelFor(height, kRowGrain, [&](int64_t begin, int64_t end) {
    for (int64_t y = begin; y < end; ++y) {
      float* const out = &nodes_.values[y * width];
      float* const row = &column_[y * stride];
      for (int64_t x = 0; x < stride; ++x) row[x] *= row[x];
      std::fill(out, out + width, kFar);
      for (int d = 0; d <= 2 * span; ++d) {
        const auto d2 = static_cast<float>((d - span) * (d - span));
        for (int x = 0; x < width; ++x) out[x] = std::min(out[x], row[x + d] + d2);
      }
      for (int x = 0; x < width; ++x) out[x] = std::sqrt(out[x]);
    }
  });
}

// Distance from node (x, y) to the nearest point, given that it is not above `at_most`. Below
// `at_least` any number below that.
float PointOutline::DistanceAt(int x, int y, float at_least, float at_most) const {
  const float enough = at_least > 0 ? at_least * at_least : 0;
  float best = at_most * at_most;
  for (int k = 0;; ++k) {
    const float gap = std::max(0.0f, static_cast<float>(k) - 0.5f);
    if (gap * gap >= best) break;
    for (int side = 0; side < (k == 0 ? 1 : 2); ++side) {
      const int row = side == 0 ? y - k : y + k;
      if (row < 0 || row >= cells_.height()) continue;
      const int half = static_cast<int>(std::sqrt(best - gap * gap) + 0.5f);
      const int first = std::max(0, x - half), last = std::min(cells_.width() - 1, x + half);
      const int32_t end = cells_.begin(last + 1, row);
      for (int32_t i = cells_.begin(first, row); i < end; ++i) {
        const float dx = sorted_x_[i] - static_cast<float>(x);
        const float dy = sorted_y_[i] - static_cast<float>(y);
        best = std::min(best, dx * dx + dy * dy);
      }
      if (best < enough) return std::sqrt(best);
      if (gap * gap >= best) break;
    }
  }
  return std::sqrt(best);
}

// Makes D exact where the contour at `radius` can pass. Elsewhere the side is known.
void PointOutline::MeasureNodes(double radius) {
  const int width = nodes_.width;
  const auto r = static_cast<float>(radius);
  ParallelFor(nodes_.height, kRowGrain, [&](int64_t begin, int64_t end) {
    for (int64_t y = begin; y < end; ++y) {
      for (int x = 0; x < width; ++x) {
        float& D = nodes_.values[y * width + x];
        if (std::abs(D - r) > kCellError + 1) continue;
        D = DistanceAt(x, static_cast<int>(y), r - 1, D + kCellError);
      }
    }
  });
}

// Keeps of the background {D > radius} what hangs together with a node of D > hole_radius.
void PointOutline::FillHoles(double radius, double hole_radius) {
  const int width = nodes_.width, height = nodes_.height;
  const auto r = static_cast<float>(radius), hole = static_cast<float>(hole_radius);
  const std::vector<float>& D = nodes_.values;
  kept_.resize(D.size());
  stack_.clear();
  for (size_t i = 0; i < D.size(); ++i) kept_[i] = D[i] > hole;
  const auto visit = [&](int64_t i) {
    if (kept_[i] || D[i] <= r) return;
    kept_[i] = 1;
    stack_.push_back(static_cast<int32_t>(i));
  };
  const auto spread = [&](int64_t i) {
    const int x = static_cast<int>(i % width), y = static_cast<int>(i / width);
    if (x > 0) visit(i - 1);
    if (x + 1 < width) visit(i + 1);
    if (y > 0) visit(i - width);
    if (y + 1 < height) visit(i + width);
  };
  for (size_t i = 0; i < D.size(); ++i) {
    if (D[i] > hole) spread(static_cast<int64_t>(i));
    while (!stack_.empty()) {
      const int32_t next = stack_.back();
      stack_.pop_back();
      spread(next);
    }
  }
  for (size_t i = 0; i < D.size(); ++i) {
    if (!kept_[i] && D[i] > r) nodes_.values[i] = 0;
  }
}

// From D to E - radius at the nodes, whose contour at 0 is the outline.
void PointOutline::Erode(double radius) {
  const auto r = static_cast<float>(radius);
  for (float& D : nodes_.values) D = r - D;
  ExtractOutline(nodes_, 0.0f, &grown_);
  const double reach = radius + 2;
  MeasureOutline(grown_, nodes_.width, nodes_.height, reach, &to_grown_);
  ParallelFor(nodes_.pixel_count(), 4096, [&](int64_t begin, int64_t end) {
    for (int64_t i = begin; i < end; ++i) {
      const auto E = static_cast<float>(std::min(to_grown_.distance[i], reach));
      nodes_.values[i] = (nodes_.values[i] >= 0 ? E : -E) - r;
    }
  });
  ExtractOutline(nodes_, 0.0f, &outline_);
  outline_.points /= kNodesPerPixel;
  outline_.points.colwise() += Eigen::Vector2d(window_.x, window_.y);
}

void PointOutline::ReadInside(int width, int height) {
  inside_.width = width;
  inside_.height = height;
  inside_.values.assign(static_cast<size_t>(width) * height, 0.0f);
  const int x0 = std::max(0, window_.x), x1 = std::min(width, window_.x + window_.width);
  const int y0 = std::max(0, window_.y), y1 = std::min(height, window_.y + window_.height);
  for (int y = y0; y < y1; ++y) {
    for (int x = x0; x < x1; ++x) {
      const float value =
          *nodes_.at((x - window_.x) * kNodesPerPixel, (y - window_.y) * kNodesPerPixel);
      *inside_.at(x, y) = value >= 0 ? 1.0f : 0.0f;
    }
  }
}

void PointOutline::Build(const std::vector<float>& u, const std::vector<float>& v, int width,
                         int height, const ClosingRadii& radii) {
  Sort(u, v, width, height, Margin(radii));
  const double radius = kNodesPerPixel * radii.radius;
  const double hole_radius = kNodesPerPixel * radii.hole_radius;
  outline_.points.resize(2, 0);
  outline_.segments.resize(2, 0);
  if (cells_.size() > 0) {
    MeasureCells(hole_radius + kCellError + 1);
    MeasureNodes(radius);
    FillHoles(radius, hole_radius);
    Erode(radius);
  }
  ReadInside(width, height);
}

}  // namespace cagefit
