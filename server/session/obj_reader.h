// Reads the part of Wavefront OBJ that `cagefit template` writes: a child's output, not a user's
// file.
#ifndef CAGEFIT_SERVER_SESSION_OBJ_READER_H_
#define CAGEFIT_SERVER_SESSION_OBJ_READER_H_

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "core/mesh/control_mesh.h"

namespace cagefit::server {

// Lines "v x y z" and "f a b c" (indices from 1), "# cagefit crease a b" and "# cagefit corner a",
// other comments and blank lines. INVALID_ARGUMENT naming
// the line for anything else, more than `max_vertices` vertices, or an invalid control mesh.
absl::StatusOr<ControlMesh> ReadTemplateObj(absl::string_view text, int32_t max_vertices);

}  // namespace cagefit::server

#endif  // CAGEFIT_SERVER_SESSION_OBJ_READER_H_
