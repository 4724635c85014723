// A fitted sequence as a glTF scene, which engines and browsers play.
#ifndef CAGEFIT_CLIENT_IO_GLTF_WRITER_H_
#define CAGEFIT_CLIENT_IO_GLTF_WRITER_H_

#include <string>

#include "absl/status/status.h"
#include "client/io/mesh_sequence.h"

namespace cagefit::client {

// A .glb file [https://registry.khronos.org/glTF/specs/2.0/glTF-2.0.html]. glTF has no subdivision
// surfaces: its mesh is the limit surface, the control mesh refined `levels` times, with exact
// normals (core/subdiv/shaded_mesh.h). It has the shape of the first frame, a morph target for each
// further one, named "frame NUMBER", and an animation whose weights turn on one at a time, linearly
// in between; time is 0 in the first frame. Positions are float32, in units; the node brings them
// to metres and to +Y up. Whole or not at all: written beside and renamed. INVALID_ARGUMENT without
// a frame, or when the file would have 4 GiB, which the format cannot hold.
absl::Status WriteGltf(const std::string& path, const MeshSequence& sequence, int levels,
                       const SceneSettings& settings);

}  // namespace cagefit::client

#endif  // CAGEFIT_CLIENT_IO_GLTF_WRITER_H_
