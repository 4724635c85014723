#include "client/commands/true_motion.h"

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "client/commands/input_files.h"
#include "client/io/geometry_file.h"
#include "core/base/status.h"

namespace cagefit::client {

absl::StatusOr<TrueMotion> TrueMotion::Open(const std::vector<std::string>& inputs, size_t frames) {
  ASSIGN_OR_RETURN(std::vector<std::string> files, ListInputs(inputs));
  if (files.size() != frames) {
    return absl::InvalidArgumentError(
        absl::StrCat(absl::StrJoin(inputs, " "), ": ", files.size(),
                     " frames of the true motion; expected as many as there are frames, ", frames));
  }
  return TrueMotion(std::move(files));
}

absl::Status TrueMotion::Check() const {
  TrueMotion motion(files_);
  for (size_t k = 0; k < files_.size(); ++k) RETURN_IF_ERROR(motion.Vertices(k).status());
  return absl::OkStatus();
}

absl::StatusOr<Points3d> TrueMotion::Vertices(size_t frame) {
  const std::string& file = files_.at(frame);
  ASSIGN_OR_RETURN(Geometry geometry, ReadGeometry(file));
  TriangleMesh& mesh = geometry.mesh;
  if (vertices_ == 0) {
    if (mesh.vertices.cols() == 0) {
      return absl::InvalidArgumentError(absl::StrCat(file, ": it has no vertices"));
    }
    vertices_ = mesh.vertices.cols();
    triangles_ = std::move(mesh.triangles);
    first_ = file;
    return std::move(mesh.vertices);
  }
  if (mesh.vertices.cols() != vertices_ || mesh.triangles.cols() != triangles_.cols()) {
    return absl::InvalidArgumentError(
        absl::StrCat(file, ": ", mesh.vertices.cols(), " vertices and ", mesh.triangles.cols(),
                     " triangles; ", first_, " has ", vertices_, " and ", triangles_.cols(),
                     ", and the true motion needs one connectivity for all frames"));
  }
  if (mesh.triangles != triangles_) {
    return absl::InvalidArgumentError(
        absl::StrCat(file, ": its ", triangles_.cols(), " triangles are not those of ", first_,
                     ", and the true motion needs one connectivity for all frames"));
  }
  return std::move(mesh.vertices);
}

}  // namespace cagefit::client
