// A fitted sequence, for the formats that keep it in one file.
#ifndef CAGEFIT_CLIENT_IO_MESH_SEQUENCE_H_
#define CAGEFIT_CLIENT_IO_MESH_SEQUENCE_H_

#include <cstdint>
#include <vector>

#include "core/mesh/control_mesh.h"

namespace cagefit::client {

// Control vertices over time: `frames` ascend, and each has 3 x n vertices of `cage`.
struct MeshSequence {
  struct Frame {
    int64_t number = 0;
    const Points3d* vertices = nullptr;
  };
  const ControlMesh* cage = nullptr;
  std::vector<Frame> frames;
};

struct SceneSettings {
  double frames_per_second = 24;
  double metres_per_unit = 1;
  char up_axis = 'Y';  // or 'Z'
};

}  // namespace cagefit::client

#endif  // CAGEFIT_CLIENT_IO_MESH_SEQUENCE_H_
