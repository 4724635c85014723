// The true motion of a sequence: one file a frame, whose vertices correspond from file to file.
#ifndef CAGEFIT_CLIENT_COMMANDS_TRUE_MOTION_H_
#define CAGEFIT_CLIENT_COMMANDS_TRUE_MOTION_H_

#include <cstddef>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/mesh/triangle_mesh.h"

namespace cagefit::client {

// One frame is in memory at a time.
class TrueMotion {
 public:
  // Files and folders as ListInputs takes them, in order of frames. INVALID_ARGUMENT, naming the
  // input and both counts, unless there are `frames` of them.
  static absl::StatusOr<TrueMotion> Open(const std::vector<std::string>& inputs, size_t frames);

  // Reads all files. INVALID_ARGUMENT, naming the file and the counts, where one has other numbers
  // of vertices or triangles than the first, or the same triangles in another order.
  absl::Status Check() const;

  // Vertices in frame k (3 x n); errors as Check and ReadGeometry.
  absl::StatusOr<Points3d> Vertices(size_t frame);

 private:
  explicit TrueMotion(std::vector<std::string> files) : files_(std::move(files)) {}

  std::vector<std::string> files_;
  Triangles triangles_;   // of the first file that was read
  int64_t vertices_ = 0;  // of that file; 0: none was read
  std::string first_;     // its name
};

}  // namespace cagefit::client

#endif  // CAGEFIT_CLIENT_COMMANDS_TRUE_MOTION_H_
