// Control vertices from the deltas of a stream.
#ifndef CAGEFIT_CLIENT_DELTA_DECODER_H_
#define CAGEFIT_CLIENT_DELTA_DECODER_H_

#include "absl/status/status.h"
#include "cagefit/v1/fitting.pb.h"
#include "core/codec/vertex_delta.h"

namespace cagefit::client {

class DeltaDecoder {
 public:
  // Applies one fitted frame's delta, whichever encoding it has. DATA_LOSS, leaving the vertices as
  // they were, when it does not reproduce the server's checksum.
  absl::Status Apply(const v1::VertexDelta& delta);

  // 3 x n, user units; 3 x 0 before the first delta.
  const Points3d& vertices() const { return vertices_; }

 private:
  absl::Status ApplyPositions(const v1::VertexDelta& delta);

  GridPoints q_;
  Points3d vertices_;
};

}  // namespace cagefit::client

#endif  // CAGEFIT_CLIENT_DELTA_DECODER_H_
