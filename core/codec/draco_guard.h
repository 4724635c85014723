// Draco's decoders with every claim of the bytes checked before it costs memory or time. Internal
// to core/codec.
//
// The checks sit inside the decoders (overridden steps that look ahead in the buffer and then call
// the original), because the descriptors of a mesh's attributes stand behind its entropy-coded
// connectivity, where no parser of headers can find them.
#ifndef CAGEFIT_CORE_CODEC_DRACO_GUARD_H_
#define CAGEFIT_CORE_CODEC_DRACO_GUARD_H_

#include <draco/mesh/mesh.h>
#include <draco/point_cloud/point_cloud.h>

#include <memory>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "core/codec/draco_codec.h"

namespace cagefit {

struct GuardedGeometry {
  std::unique_ptr<draco::PointCloud> points;  // 1 to max_points
  const draco::Mesh* mesh = nullptr;          // `points` as a mesh, or null for a cloud
};

// Face indices are in range; attribute values may still be anything.
absl::StatusOr<GuardedGeometry> DecodeGuarded(absl::string_view bytes, const DecodeLimits& limits);

}  // namespace cagefit

#endif  // CAGEFIT_CORE_CODEC_DRACO_GUARD_H_
