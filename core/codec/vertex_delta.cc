#include "core/codec/vertex_delta.h"

#include <isa-l/crc.h>

#include <cmath>
#include <limits>

#include "absl/strings/str_format.h"

namespace cagefit {

absl::StatusOr<GridPoints> Quantize(const Points3d& vertices, const VertexGrid& grid) {
  GridPoints q(3, vertices.cols());
  for (int64_t v = 0; v < vertices.cols(); ++v) {
    for (int axis = 0; axis < 3; ++axis) {
      const double steps = std::round((vertices(axis, v) - grid.origin[axis]) / grid.quantum);
      if (!(steps >= std::numeric_limits<int32_t>::min() &&
            steps <= std::numeric_limits<int32_t>::max())) {
        return absl::OutOfRangeError(
            absl::StrFormat("vertex %d: coordinate %g is outside the grid of quantum %g", v,
                            vertices(axis, v), grid.quantum));
      }
      q(axis, v) = static_cast<int32_t>(steps);
    }
  }
  return q;
}

Points3d Dequantize(const GridPoints& q, const VertexGrid& grid) {
  return (grid.quantum * q.cast<double>()).colwise() + grid.origin;
}

uint32_t Checksum(const GridPoints& q) {
  // Columns are contiguous x y z; little-endian is the byte order of every platform that we build
  // for.
  static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__);
  // ISA-L leaves the inversions before and after to its caller, and does not write through the
  // pointer.
  unsigned char* bytes = reinterpret_cast<unsigned char*>(const_cast<int32_t*>(q.data()));
  return ~crc32_iscsi(bytes, static_cast<int>(q.size() * sizeof(int32_t)), ~0u);
}

VertexDelta EncodeKey(const GridPoints& q) { return {true, q, Checksum(q)}; }

VertexDelta EncodeDelta(const GridPoints& before, const GridPoints& after) {
  VertexDelta delta;
  // Unsigned arithmetic wraps by definition.
  delta.values = (after.cast<uint32_t>() - before.cast<uint32_t>()).cast<int32_t>();
  delta.checksum = Checksum(after);
  return delta;
}

absl::Status ApplyDelta(const VertexDelta& delta, GridPoints* q) {
  if (!delta.key && delta.values.cols() != q->cols()) {
    return absl::DataLossError(
        absl::StrFormat("delta: %d vertices where %d are known", delta.values.cols(), q->cols()));
  }
  GridPoints next = delta.values;
  if (!delta.key) next = (q->cast<uint32_t>() + delta.values.cast<uint32_t>()).cast<int32_t>();
  const uint32_t checksum = Checksum(next);
  if (checksum != delta.checksum) {
    return absl::DataLossError(
        absl::StrFormat("delta: checksum %08x where %08x was sent", checksum, delta.checksum));
  }
  q->swap(next);
  return absl::OkStatus();
}

}  // namespace cagefit
