// How the vector code of the distance fields walks over the points near x: runs of sorted points,
// some at a time.
#ifndef CAGEFIT_CORE_CLOUD_FIELD_RUNS_H_
#define CAGEFIT_CORE_CLOUD_FIELD_RUNS_H_

#include <cstdint>

#include "core/cloud/cell_grid.h"

namespace cagefit {

// Points begin to end of the grid.
struct Run {
  int32_t begin, end;
};
// As many as a radius of one cell meets, so that most samples take one call.
inline constexpr int kMaxRuns = 27;
// Doubles in a vector register, at most.
inline constexpr int kMaxLanes = 8;

// Calls accumulate(runs, count) until all points within h of x are covered.
template <typename Accumulate>
void ForRuns(const CellGrid& grid, const Eigen::Vector3d& x, double h,
             const Accumulate& accumulate) {
  Run runs[kMaxRuns];
  int count = 0;
  grid.ForEachRun(x, h, [&](int32_t begin, int32_t end) {
    runs[count++] = {begin, end};
    if (count < kMaxRuns) return;
    accumulate(runs, count);
    count = 0;
  });
  if (count > 0) accumulate(runs, count);
}

}  // namespace cagefit

#endif  // CAGEFIT_CORE_CLOUD_FIELD_RUNS_H_
