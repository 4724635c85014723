// What the benchmarks run on: real data where it is, else captures that the project makes.
#ifndef CAGEFIT_TESTS_BENCH_SCENES_H_
#define CAGEFIT_TESTS_BENCH_SCENES_H_

#include <string>
#include <vector>

#include "core/cloud/point_cloud.h"
#include "core/mesh/control_mesh.h"

namespace cagefit::bench {

struct Scene {
  std::string label;  // of the input, for the table
  ControlMesh cage;
  std::vector<std::string> frames;  // Draco
  std::vector<PointCloud> clouds;   // the first frames, decoded
};

// The T-shirt with 2,046 control vertices, or a tube of as many points. With CAGEFIT_BENCH_SMALL, a
// small tube. Made once.
const Scene& Sequence();

// The closed bunny with 4,667 control vertices, or a blob with as many.
const Scene& Static();

}  // namespace cagefit::bench

#endif  // CAGEFIT_TESTS_BENCH_SCENES_H_
