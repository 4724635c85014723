// Draco bytes that the project itself does not write, made with Draco's own encoder.
#ifndef CAGEFIT_TESTS_CORE_CODEC_DRACO_SAMPLES_H_
#define CAGEFIT_TESTS_CORE_CODEC_DRACO_SAMPLES_H_

#include <string>
#include <vector>

#include "core/mesh/triangle_mesh.h"

namespace cagefit::testing {

// A wavy, open n x n grid: 2 (n-1)^2 triangles.
TriangleMesh WavyGrid(int n);

struct EdgebreakerSample {
  bool normals = false;              // (0, 0, 1) at every vertex
  bool texture_coordinates = false;  // predicted by Draco's scheme for them
  bool metadata = false;
};
std::string EdgebreakerBytes(const TriangleMesh& mesh, const EdgebreakerSample& sample);

// Points and normals, coded one after the other.
std::string SequentialCloudBytes(const Points3f& points, const Points3f& normals);

struct NamedBytes {
  const char* name;
  std::string bytes;
};
// One small sample of every method, with and without more attributes and metadata.
std::vector<NamedBytes> AllDracoSamples();

}  // namespace cagefit::testing

#endif  // CAGEFIT_TESTS_CORE_CODEC_DRACO_SAMPLES_H_
