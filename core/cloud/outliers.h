// Points of a cloud that belong to no surface: stray measurements, flying pixels, small clumps.
//
// A point is an outlier when fewer than kOutlierNeighbors others lie within r of it, unless it is
// part of a sparse surface. r is 2.5 to 4 times the median distance to the 8th neighbour, more
// where that distance varies more over the cloud (by the median absolute deviation of its
// logarithm, so that outliers do not raise r). A sparse surface: the nearest points lie close to a
// plane, the point too, and they are about as far from their own neighbours as the point is from
// its own. Clumps of up to kOutlierNeighbors points go as a whole; larger ones count as surface.
#ifndef CAGEFIT_CORE_CLOUD_OUTLIERS_H_
#define CAGEFIT_CORE_CLOUD_OUTLIERS_H_

#include <cstdint>
#include <vector>

#include "core/cloud/cell_grid.h"

namespace cagefit {

inline constexpr int kOutlierNeighbors = 8;

// Indices in the cloud, ascending, of the outliers among the points of its grid. A look at the
// cells decides first whether any point stands apart: where none does, not even by clumps, no point
// is looked at and the answer is none. Uses several threads; the result does not depend on their
// number.
std::vector<int32_t> FindOutliers(const CellGrid& grid);

// Takes the points at `indices` (ascending) and their normals out; the others keep their order.
void RemovePoints(const std::vector<int32_t>& indices, PointCloud* cloud);

}  // namespace cagefit

#endif  // CAGEFIT_CORE_CLOUD_OUTLIERS_H_
