// The first bytes of a Draco bitstream, and its metadata. Internal to core/codec.
//
// Metadata is a tree of names and binary values between the header and the geometry. Draco's own
// reader recurses without a limit and allocates what a size field asks for, so metadata is skipped
// here and never given to Draco.
#ifndef CAGEFIT_CORE_CODEC_DRACO_HEADER_H_
#define CAGEFIT_CORE_CODEC_DRACO_HEADER_H_

#include <cstddef>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace cagefit {

enum class DracoMethod { kSequentialCloud, kKdTreeCloud, kSequentialMesh, kEdgebreakerMesh };

// Magic 5, version 2, geometry type, method, flags 2.
inline constexpr size_t kDracoHeaderBytes = 11;

struct DracoHeader {
  DracoMethod method = DracoMethod::kSequentialCloud;
  int version = 0;  // 100 * major + minor
  bool has_metadata = false;

  bool is_mesh() const {
    return method == DracoMethod::kSequentialMesh || method == DracoMethod::kEdgebreakerMesh;
  }
};

absl::StatusOr<DracoHeader> ReadDracoHeader(absl::string_view bytes);

// `bytes` has a valid header that announces metadata. Returns the offset of the geometry.
// INVALID_ARGUMENT when the metadata is cut off or nested deeper than 16.
absl::StatusOr<size_t> DracoMetadataEnd(absl::string_view bytes);

}  // namespace cagefit

#endif  // CAGEFIT_CORE_CODEC_DRACO_HEADER_H_
