#include "core/image/marching_squares.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace cagefit {

namespace {

//     0 --e0-- 1
//     |        |      corners and edges of a cell, clockwise as seen in the image;
//     e3       e1     edge k goes from corner k to corner k + 1
//     |        |
//     3 --e2-- 2
using Corners = std::array<float, 4>;  // F - level

struct Contour {
  int count = 0;
  std::array<std::array<int, 2>, 2> edges;  // of each segment: from, to
};

Contour ContourOf(const Corners& f) {
  Contour contour;
  std::array<bool, 4> in;
  for (int k = 0; k < 4; ++k) in[k] = f[k] >= 0;
  const bool saddle = in[0] == in[2] && in[1] == in[3] && in[0] != in[1];
  const float inner = in[0] ? f[0] * f[2] : f[1] * f[3];
  const float outer = in[0] ? f[1] * f[3] : f[0] * f[2];
  // Clockwise around the cell a segment starts where the inside is left, and ends where it is
  // entered next: the piece of outside in between is cut off. With the inside split in two it ends
  // where the inside was entered last.
  const int step = saddle && inner < outer ? 3 : 1;
  for (int k = 0; k < 4; ++k) {
    if (!in[k] || in[(k + 1) % 4]) continue;
    int end = (k + step) % 4;
    while (in[end] || !in[(end + 1) % 4]) end = (end + step) % 4;
    contour.edges[contour.count++] = {k, end};
  }
  return contour;
}

// Where on edge k the field crosses the level, as a share of the way right or down: the two cells
// of an edge get the same number.
double Crossing(const Corners& f, int k) {
  const double from = f[k], to = f[(k + 1) % 4];
  return k < 2 ? from / (from - to) : to / (to - from);
}

Eigen::Vector2d PointOn(const Corners& f, int k) {
  const double t = Crossing(f, k);
  switch (k) {
    case 0:
      return {t, 0};
    case 1:
      return {1, t};
    case 2:
      return {t, 1};
    default:
      return {0, t};
  }
}

bool IsCrossed(const Corners& f) {
  const bool in = f[0] >= 0;
  return (f[1] >= 0) != in || (f[2] >= 0) != in || (f[3] >= 0) != in;
}

// The corners of the cell whose first one is pixel (x, y).
Corners CornersAt(const Image& field, float level, int x, int y) {
  const int x0 = std::max(x, 0), x1 = std::min(x + 1, field.width - 1);
  const int y0 = std::max(y, 0), y1 = std::min(y + 1, field.height - 1);
  return {*field.at(x0, y0) - level, *field.at(x1, y0) - level, *field.at(x1, y1) - level,
          *field.at(x0, y1) - level};
}

}  // namespace

void ExtractOutline(const Image& field, float level, Outline* out) {
  std::vector<Eigen::Vector2d> points;
  std::vector<Eigen::Vector2i> segments;
  // Points on the edges of this row of cells, -1: none yet. The cell of column x has entry x + 1.
  std::vector<int32_t> top(field.width + 2, -1), bottom(field.width + 2, -1);
  std::vector<int32_t> left(field.width + 2, -1);
  for (int y = -1; y < field.height; ++y) {
    std::fill(bottom.begin(), bottom.end(), -1);
    std::fill(left.begin(), left.end(), -1);
    const float* const upper = field.at(0, std::max(y, 0));
    const float* const lower = field.at(0, std::min(y + 1, field.height - 1));
    // Most cells are not crossed: their corners are compared before anything else.
    const auto column = [&](int x) {
      const int k = std::clamp(x, 0, field.width - 1);
      return (upper[k] - level >= 0 ? 1 : 0) + (lower[k] - level >= 0 ? 2 : 0);
    };
    int left_column = column(-1);
    for (int x = -1; x < field.width; ++x) {
      const int right_column = column(x + 1);
      const bool crossed = left_column != right_column || left_column % 3 != 0;
      left_column = right_column;
      if (!crossed) continue;
      const Corners f = CornersAt(field, level, x, y);
      const std::array<int32_t*, 4> ids = {&top[x + 1], &left[x + 2], &bottom[x + 1], &left[x + 1]};
      const Contour contour = ContourOf(f);
      for (int s = 0; s < contour.count; ++s) {
        Eigen::Vector2i segment;
        for (int end = 0; end < 2; ++end) {
          const int edge = contour.edges[s][end];
          int32_t& id = *ids[edge];
          if (id < 0) {
            id = static_cast<int32_t>(points.size());
            points.push_back(Eigen::Vector2d(x, y) + PointOn(f, edge));
          }
          segment[end] = id;
        }
        segments.push_back(segment);
      }
    }
    std::swap(top, bottom);
  }
  out->points.resize(2, static_cast<int64_t>(points.size()));
  for (size_t i = 0; i < points.size(); ++i) out->points.col(i) = points[i];
  out->segments.resize(2, static_cast<int64_t>(segments.size()));
  for (size_t i = 0; i < segments.size(); ++i) out->segments.col(i) = segments[i];
}

bool InsideOutline(const Image& field, float level, const Eigen::Vector2d& point) {
  const int x = std::clamp(static_cast<int>(std::floor(point[0])), -1, field.width - 1);
  const int y = std::clamp(static_cast<int>(std::floor(point[1])), -1, field.height - 1);
  const Corners f = CornersAt(field, level, x, y);
  if (!IsCrossed(f)) return f[0] >= 0;
  const Contour contour = ContourOf(f);
  const Eigen::Vector2d p = point - Eigen::Vector2d(x, y);
  int right_of = 0;
  for (int s = 0; s < contour.count; ++s) {
    const Eigen::Vector2d a = PointOn(f, contour.edges[s][0]), b = PointOn(f, contour.edges[s][1]);
    const Eigen::Vector2d d = b - a, ap = p - a;
    if (d[0] * ap[1] - d[1] * ap[0] > 0) ++right_of;
  }
  // Of two segments the inside lies between: right of both, or, where it is split, of either.
  const bool joined = contour.count == 2 && contour.edges[0][1] == (contour.edges[0][0] + 1) % 4;
  return right_of >= (joined ? 2 : 1);
}

}  // namespace cagefit
