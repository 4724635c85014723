// Control vertices on an integer grid, and their closed-loop differences from frame to frame.
//
//   x = origin + quantum * q      (double, no fused multiply-add; q is int32)
//
// Both sides keep q and add integers only, so nothing adds up to drift and the client's vertices
// equal the server's to the bit.
#ifndef CAGEFIT_CORE_CODEC_VERTEX_DELTA_H_
#define CAGEFIT_CORE_CODEC_VERTEX_DELTA_H_

#include <cstdint>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/base/types.h"

namespace cagefit {

using GridPoints = Eigen::Matrix<int32_t, 3, Eigen::Dynamic>;  // 3 x n

struct VertexGrid {
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();  // user units
  double quantum = 0;                                // user units, > 0
};

// Nearest grid points, halves away from zero. OUT_OF_RANGE naming the vertex when a coordinate is
// not finite or outside int32; INVALID_ARGUMENT when the grid has no positive, finite quantum.
absl::StatusOr<GridPoints> Quantize(const Points3d& vertices, const VertexGrid& grid);
Points3d Dequantize(const GridPoints& q, const VertexGrid& grid);

// CRC-32C (Castagnoli) over q as little-endian int32, vertex by vertex.
uint32_t Checksum(const GridPoints& q);

// What a reply carries: q itself in a key frame, else q - q of the frame before (wrapping in
// int32).
struct VertexDelta {
  bool key = false;
  GridPoints values;      // 3 x n
  uint32_t checksum = 0;  // of q after this delta
};

VertexDelta EncodeKey(const GridPoints& q);
// Wraps in int32, as the decoder does, so every pair of states of one size has a delta.
VertexDelta EncodeDelta(const GridPoints& before, const GridPoints& after);

// Applies `delta` to *q. DATA_LOSS, leaving *q as it was, when the checksum or the shape does not
// agree.
absl::Status ApplyDelta(const VertexDelta& delta, GridPoints* q);

}  // namespace cagefit

#endif  // CAGEFIT_CORE_CODEC_VERTEX_DELTA_H_
