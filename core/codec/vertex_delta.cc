#include "core/codec/vertex_delta.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <utility>

#include "absl/strings/str_format.h"
#include "core/codec/crc32c.h"

namespace cagefit {
namespace {

static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__,
              "Checksum() reads q in place, which is its wire form on little-endian machines only");

// Signed overflow is undefined, unsigned wraps; the casts back and forth keep the bits.
int32_t WrappingAdd(int32_t a, int32_t b) {
  return static_cast<int32_t>(static_cast<uint32_t>(a) + static_cast<uint32_t>(b));
}

int32_t WrappingSubtract(int32_t a, int32_t b) {
  return static_cast<int32_t>(static_cast<uint32_t>(a) - static_cast<uint32_t>(b));
}

absl::Status OutsideGrid(Eigen::Index vertex, int axis, double x) {
  return absl::OutOfRangeError(
      absl::StrFormat("vertex %d: coordinate %c = %g does not fit the int32 grid of the session",
                      static_cast<int64_t>(vertex), "xyz"[axis], x));
}

}  // namespace

absl::StatusOr<GridPoints> Quantize(const Points3d& vertices, const VertexGrid& grid) {
  if (!(grid.quantum > 0) || !std::isfinite(grid.quantum) || !grid.origin.allFinite()) {
    return absl::InvalidArgumentError(absl::StrFormat(
        "grid: quantum %g must be positive and finite, origin finite", grid.quantum));
  }
  constexpr double kMin = std::numeric_limits<int32_t>::min();
  constexpr double kMax = std::numeric_limits<int32_t>::max();
  GridPoints q(3, vertices.cols());
  for (Eigen::Index j = 0; j < vertices.cols(); ++j) {
    for (int axis = 0; axis < 3; ++axis) {
      const double steps = std::round((vertices(axis, j) - grid.origin[axis]) / grid.quantum);
      if (!(steps >= kMin && steps <= kMax)) return OutsideGrid(j, axis, vertices(axis, j));
      q(axis, j) = static_cast<int32_t>(steps);
    }
  }
  return q;
}

Points3d Dequantize(const GridPoints& q, const VertexGrid& grid) {
  return (grid.quantum * q.cast<double>()).colwise() + grid.origin;
}

uint32_t Checksum(const GridPoints& q) {
  return Crc32c({reinterpret_cast<const char*>(q.data()), q.size() * sizeof(int32_t)});
}

VertexDelta EncodeKey(const GridPoints& q) { return {/*key=*/true, q, Checksum(q)}; }

VertexDelta EncodeDelta(const GridPoints& before, const GridPoints& after) {
  assert(before.cols() == after.cols());
  return {/*key=*/false, after.binaryExpr(before, &WrappingSubtract), Checksum(after)};
}

absl::Status ApplyDelta(const VertexDelta& delta, GridPoints* q) {
  if (!delta.key && delta.values.cols() != q->cols()) {
    return absl::DataLossError(absl::StrFormat("delta of %d vertices for a state of %d vertices",
                                               static_cast<int64_t>(delta.values.cols()),
                                               static_cast<int64_t>(q->cols())));
  }
  GridPoints after = delta.key ? delta.values : q->binaryExpr(delta.values, &WrappingAdd).eval();
  const uint32_t checksum = Checksum(after);
  if (checksum != delta.checksum) {
    return absl::DataLossError(absl::StrFormat(
        "checksum 0x%08x of the control vertices, expected 0x%08x", checksum, delta.checksum));
  }
  *q = std::move(after);
  return absl::OkStatus();
}

}  // namespace cagefit
