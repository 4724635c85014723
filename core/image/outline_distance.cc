#include "core/image/outline_distance.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/parallel.h"

namespace cagefit {

namespace {

constexpr int kStripRows = 16;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

struct Range {
  int first, last;  // empty when first > last
};

// Pixels of [0, count) in [low, high]: empty when there are none, or when an end is not a number.
Range PixelsIn(double low, double high, int count) {
  if (!(low <= count - 1.0) || !(high >= 0.0)) return {0, -1};
  return {static_cast<int>(std::ceil(std::max(low, 0.0))),
          static_cast<int>(std::floor(std::min(high, count - 1.0)))};
}

struct Segment {
  Segment(const Outline& outline, int32_t s)
      : a(outline.points.col(outline.segments(0, s))),
        b(outline.points.col(outline.segments(1, s))),
        d(b - a),
        squared_length(d.squaredNorm()),
        inverse(1 / squared_length) {}

  // From the end itself where that is the nearest point: the segments that meet in it then give
  // the same number, and the tie goes to the lower index. All three are computed and one chosen,
  // since which one it is changes along a row too often for a branch.
  double SquaredDistance(double x, double y) const {
    const double ax = x - a[0], ay = y - a[1], bx = x - b[0], by = y - b[1];
    const double along = ax * d[0] + ay * d[1], across = ax * d[1] - ay * d[0];
    const double to_a = ax * ax + ay * ay, to_b = bx * bx + by * by;
    const double to_line = across * across * inverse;
    const double to_end = along > 0 ? to_b : to_a;
    return along > 0 && along < squared_length ? to_line : to_end;
  }

  Range Rows(double reach, int height) const {
    if (!std::isfinite(squared_length) || !a.allFinite()) return {0, -1};
    return PixelsIn(std::min(a[1], b[1]) - reach, std::max(a[1], b[1]) + reach, height);
  }

  // Columns of row y that may be within reach: those of the part of the segment between y - reach
  // and y + reach, grown by the reach. At most 1.5 times as many as are.
  Range Columns(int y, double reach, int width) const {
    double t0 = 0, t1 = 1;
    if (d[1] != 0) {
      const double u = (y - reach - a[1]) / d[1], v = (y + reach - a[1]) / d[1];
      t0 = std::clamp(std::min(u, v), 0.0, 1.0);
      t1 = std::clamp(std::max(u, v), 0.0, 1.0);
    }
    const double x0 = a[0] + t0 * d[0], x1 = a[0] + t1 * d[0];
    // Rounding of x grows with the segment's size.
    const double grown = reach + 1e-14 * (std::abs(a[0]) + std::abs(d[0]));
    return PixelsIn(std::min(x0, x1) - grown, std::max(x0, x1) + grown, width);
  }

  Eigen::Vector2d a, b, d;
  double squared_length, inverse;
};

// Counting sort of the segments into the strips of rows that they reach.
void SortIntoStrips(const Outline& outline, double reach, OutlineDistance* out) {
  const int strips = (out->height + kStripRows - 1) / kStripRows;
  const auto count = static_cast<int32_t>(outline.segments.cols());
  out->strip_begin.assign(strips + 2, 0);
  for (int32_t s = 0; s < count; ++s) {
    const Range rows = Segment(outline, s).Rows(reach, out->height);
    if (rows.first > rows.last) continue;
    for (int k = rows.first / kStripRows; k <= rows.last / kStripRows; ++k) {
      ++out->strip_begin[k + 2];
    }
  }
  for (int k = 2; k <= strips + 1; ++k) out->strip_begin[k] += out->strip_begin[k - 1];
  out->strip_segments.resize(out->strip_begin[strips + 1]);
  for (int32_t s = 0; s < count; ++s) {
    const Range rows = Segment(outline, s).Rows(reach, out->height);
    if (rows.first > rows.last) continue;
    for (int k = rows.first / kStripRows; k <= rows.last / kStripRows; ++k) {
      out->strip_segments[out->strip_begin[k + 1]++] = s;
    }
  }
}

// Squared distances to segment s in the given rows of `out->distance`.
void Draw(const Outline& outline, int32_t s, Range strip, double reach, OutlineDistance* out) {
  const Segment segment(outline, s);
  const Range rows = segment.Rows(reach, out->height);
  for (int y = std::max(rows.first, strip.first); y <= std::min(rows.last, strip.last); ++y) {
    const Range columns = segment.Columns(y, reach, out->width);
    double* const distance = &out->distance[static_cast<int64_t>(y) * out->width];
    int32_t* const index = &out->segment[static_cast<int64_t>(y) * out->width];
    for (int x = columns.first; x <= columns.last; ++x) {
      const double d2 = segment.SquaredDistance(x, y);
      const bool nearer = d2 <= reach * reach && d2 < distance[x];
      distance[x] = nearer ? d2 : distance[x];
      index[x] = nearer ? s : index[x];
    }
  }
}

}  // namespace

void MeasureOutline(const Outline& outline, int width, int height, double reach,
                    OutlineDistance* out) {
  out->width = width;
  out->height = height;
  const int64_t pixels = static_cast<int64_t>(width) * height;
  out->distance.assign(pixels, kInfinity);
  out->segment.assign(pixels, -1);
  SortIntoStrips(outline, reach, out);
  // A strip is one thread's, and draws its segments in order: the first of equals stays.
  ParallelFor(height, kStripRows, [&](int64_t begin, int64_t end) {
    const int64_t strip = begin / kStripRows;
    const Range rows{static_cast<int>(begin), static_cast<int>(end - 1)};
    for (int32_t i = out->strip_begin[strip]; i < out->strip_begin[strip + 1]; ++i) {
      Draw(outline, out->strip_segments[i], rows, reach, out);
    }
    for (int64_t p = begin * width; p < end * width; ++p) {
      if (out->segment[p] >= 0) out->distance[p] = std::sqrt(out->distance[p]);
    }
  });
}

}  // namespace cagefit
