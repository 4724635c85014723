// Normals for clouds that have none.
#ifndef CAGEFIT_CORE_CLOUD_NORMALS_H_
#define CAGEFIT_CORE_CLOUD_NORMALS_H_

#include <optional>

#include "absl/status/status.h"
#include "core/cloud/point_cloud.h"

namespace cagefit {

struct NormalOptions {
  int neighbors = 16;  // of each point, itself included; 3 to 100
  std::optional<Eigen::Vector3d>
      sensor;  // orient towards this position; otherwise consistently, outwards
};

// Writes cloud->normals: the direction of least variance among the nearest neighbours (PCA), or in
// balls large enough for the cloud's noise (cloud/noise.h) where that needs more of them; oriented
// towards the sensor, or by propagation along a minimum spanning tree of the neighbour graph with
// weights 1 - |n_i . n_j| [hoppe1992], each connected part outwards: by the sign of its enclosed
// volume or, where it encloses none, by its topmost point. INVALID_ARGUMENT when there are fewer
// points than neighbours.
absl::Status EstimateNormals(const NormalOptions& options, PointCloud* cloud);

}  // namespace cagefit

#endif  // CAGEFIT_CORE_CLOUD_NORMALS_H_
