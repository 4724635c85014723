// What a Draco bitstream claims about its size, read ahead of the decoder and held against limits.
// Internal to core/codec.
#ifndef CAGEFIT_CORE_CODEC_DRACO_CLAIMS_H_
#define CAGEFIT_CORE_CODEC_DRACO_CLAIMS_H_

#include <draco/core/decoder_buffer.h>

#include <cstdint>

#include "absl/status/status.h"
#include "core/codec/draco_codec.h"
#include "core/codec/draco_header.h"

namespace cagefit {

// Adds up the memory that a decoder is about to take.
class DracoBudget {
 public:
  DracoBudget(const DecodeLimits& limits, int64_t encoded_bytes)
      : limits_(limits), encoded_bytes_(encoded_bytes) {}

  // RESOURCE_EXHAUSTED above the limits, or what their `reserve` says; INVALID_ARGUMENT for no
  // points, and for more points or faces than so few bytes can plausibly hold.
  absl::Status CheckPoints(int64_t points) const;
  absl::Status CheckFaces(int64_t faces) const;
  absl::Status Take(int64_t bytes);

 private:
  const DecodeLimits limits_;
  const int64_t encoded_bytes_;
  int64_t taken_ = 0;
};

// All get a copy of the decoder's buffer, positioned at what they check.
//
// At the start of the geometry: numbers of points and faces.
absl::Status CheckGeometryClaims(const DracoHeader& header, draco::DecoderBuffer buffer,
                                 DracoBudget* budget);
// At the start of the attributes of `points` points: at most 4 attributes of at most 4 components
// and known types; in a kd-tree the repeated number of points.
absl::Status CheckAttributeClaims(const DracoHeader& header, int64_t points,
                                  draco::DecoderBuffer buffer, DracoBudget* budget);
// Behind the method and transform bytes of an attribute's prediction scheme. Schemes for texture
// coordinates read a number of orientations that Draco believes up to 2^31; it stands behind the
// entropy-coded values, which are therefore decoded once more, into nothing.
absl::Status CheckPredictionClaims(const DracoHeader& header, int64_t values, int components,
                                   draco::DecoderBuffer buffer);

}  // namespace cagefit

#endif  // CAGEFIT_CORE_CODEC_DRACO_CLAIMS_H_
