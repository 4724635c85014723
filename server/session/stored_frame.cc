#include "server/session/stored_frame.h"

#include <algorithm>
#include <cstring>
#include <utility>

#include "core/base/status.h"
#include "core/codec/draco_codec.h"

namespace cagefit::server {

int64_t EncodedDelta::StoredBytes() const {
  return static_cast<int64_t>(values.size() * sizeof(int32_t) + draco.size() +
                              positions.size() * sizeof(float));
}

int64_t StoredFrame::StoredBytes() const {
  return static_cast<int64_t>(sizeof(StoredFrame) + error.message().size()) + delta.StoredBytes();
}

double BareShare(const FitSummary& fit) {
  return static_cast<double>(fit.grown_samples + fit.far_samples) / std::max(1, fit.samples);
}

absl::StatusOr<EncodedDelta> Encode(const VertexDelta& delta, const VertexGrid& grid,
                                    DeltaEncoding encoding) {
  EncodedDelta encoded;
  encoded.key = delta.key;
  encoded.grid = grid;
  encoded.checksum = delta.checksum;
  if (encoding == DeltaEncoding::kDraco) {
    ASSIGN_OR_RETURN(encoded.draco, EncodeDracoIntegers(delta.values));
  } else {
    encoded.values = delta.values;
  }
  return encoded;
}

EncodedDelta EncodePositions(const Points3f& positions) {
  EncodedDelta encoded;
  encoded.key = true;
  encoded.positions = positions;
  // The checksum is over the floats' bits, which have the layout of grid points.
  GridPoints bits(3, positions.cols());
  std::memcpy(bits.data(), positions.data(), positions.size() * sizeof(float));
  encoded.checksum = Checksum(bits);
  return encoded;
}

absl::StatusOr<VertexDelta> Decode(const EncodedDelta& delta, int64_t vertices) {
  VertexDelta decoded;
  decoded.key = delta.key;
  decoded.checksum = delta.checksum;
  if (delta.draco.empty()) {
    decoded.values = delta.values;
  } else {
    ASSIGN_OR_RETURN(decoded.values, DecodeDracoIntegers(delta.draco, vertices));
  }
  return decoded;
}

}  // namespace cagefit::server
