// A fitted sequence as a USD scene, which 3D programs open as an animated subdivision surface.
#ifndef CAGEFIT_CLIENT_IO_USD_WRITER_H_
#define CAGEFIT_CLIENT_IO_USD_WRITER_H_

#include <string>

#include "absl/status/status.h"
#include "client/io/mesh_sequence.h"

namespace cagefit::client {

// A .usda file [https://openusd.org/release/spec_usdgeom.html]: one Mesh with subdivisionScheme
// "loop", its creases and corners, points and extent at the time code of each frame. OpenSubdiv,
// which USD renders with, makes of it the surface that was fitted, to a float's precision. Whole or
// not at all: written beside and renamed. INVALID_ARGUMENT without a frame.
absl::Status WriteUsd(const std::string& path, const MeshSequence& sequence,
                      const SceneSettings& settings);

}  // namespace cagefit::client

#endif  // CAGEFIT_CLIENT_IO_USD_WRITER_H_
