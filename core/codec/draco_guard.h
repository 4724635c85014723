// Decodes Draco bytes with every count checked before memory is taken for it. Internal to codec.
#ifndef CAGEFIT_CORE_CODEC_DRACO_GUARD_H_
#define CAGEFIT_CORE_CODEC_DRACO_GUARD_H_

#include <draco/mesh/mesh.h>

#include <memory>

#include "core/codec/draco_codec.h"

namespace cagefit {

// Attributes, and components of each, that a frame or file may have.
inline constexpr int kMaxDracoAttributes = 4;
inline constexpr int kMaxDracoComponents = 4;

struct DecodedDraco {
  std::unique_ptr<draco::PointCloud> cloud;  // a draco::Mesh where `mesh` is set
  const draco::Mesh* mesh = nullptr;
};

// Every face index of the result is below its number of points.
absl::StatusOr<DecodedDraco> GuardedDecode(absl::string_view bytes, const DecodeLimits& limits);

}  // namespace cagefit

#endif  // CAGEFIT_CORE_CODEC_DRACO_GUARD_H_
