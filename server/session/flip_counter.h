// Triangles of a surface that have turned over: a sign of a lost fit.
#ifndef CAGEFIT_SERVER_SESSION_FLIP_COUNTER_H_
#define CAGEFIT_SERVER_SESSION_FLIP_COUNTER_H_

#include <array>
#include <cstdint>
#include <vector>

#include "core/base/types.h"

namespace cagefit::server {

// A triangle counts as flipped when it is turned by more than 90 degrees against more than half of
// its neighbours, where the template's was not. Whole-body rotations therefore count nothing.
class FlipCounter {
 public:
  // `template_points` (3 x N) are the template's vertices under the same `triangles`.
  FlipCounter(const Triangles& triangles, const Points3d& template_points);

  // Share of the triangles that are flipped in `points` (3 x N).
  double Share(const Points3d& points) const;

 private:
  std::vector<char> TurnedAgainstNeighbors(const Points3d& points) const;

  Triangles triangles_;
  std::vector<std::array<int32_t, 2>> neighbors_;  // pairs of triangles that share an edge
  std::vector<int32_t> neighbor_count_;            // per triangle
  std::vector<char> turned_in_template_;           // per triangle
};

}  // namespace cagefit::server

#endif  // CAGEFIT_SERVER_SESSION_FLIP_COUNTER_H_
