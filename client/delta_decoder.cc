#include "client/delta_decoder.h"

#include <algorithm>
#include <cstring>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "core/base/status.h"
#include "core/codec/draco_codec.h"

namespace cagefit::client {
namespace {

// More than any server sends: a reply stays below 4 MiB.
constexpr int64_t kMaxVertices = 1 << 22;

absl::Status CheckTriples(const char* field, int values) {
  if (values % 3 == 0) return absl::OkStatus();
  return absl::DataLossError(absl::StrCat("delta: ", field, " has ", values, " values"));
}

absl::StatusOr<GridPoints> Values(const v1::VertexDelta& delta) {
  if (!delta.draco().empty()) {
    auto values = DecodeDracoIntegers(delta.draco(), kMaxVertices);
    if (!values.ok()) return absl::DataLossError(values.status().message());
    return values;
  }
  RETURN_IF_ERROR(CheckTriples("packed", delta.packed_size()));
  GridPoints values(3, delta.packed_size() / 3);
  std::copy(delta.packed().begin(), delta.packed().end(), values.data());
  return values;
}

}  // namespace

absl::Status DeltaDecoder::Apply(const v1::VertexDelta& delta) {
  if (delta.positions_size() > 0) return ApplyPositions(delta);
  VertexDelta decoded;
  decoded.key = delta.key();
  decoded.checksum = delta.crc32c();
  ASSIGN_OR_RETURN(decoded.values, Values(delta));
  RETURN_IF_ERROR(ApplyDelta(decoded, &q_));
  vertices_ =
      Dequantize(q_, {{delta.origin_x(), delta.origin_y(), delta.origin_z()}, delta.quantum()});
  return absl::OkStatus();
}

absl::Status DeltaDecoder::ApplyPositions(const v1::VertexDelta& delta) {
  RETURN_IF_ERROR(CheckTriples("positions", delta.positions_size()));
  // The checksum is over the floats' bits, which have the layout of grid points.
  GridPoints bits(3, delta.positions_size() / 3);
  std::memcpy(bits.data(), delta.positions().data(), delta.positions_size() * sizeof(float));
  const uint32_t checksum = Checksum(bits);
  if (checksum != delta.crc32c()) {
    return absl::DataLossError(
        absl::StrFormat("delta: checksum %08x where %08x was sent", checksum, delta.crc32c()));
  }
  vertices_.resize(3, bits.cols());
  std::copy(delta.positions().begin(), delta.positions().end(), vertices_.data());
  return absl::OkStatus();
}

}  // namespace cagefit::client
