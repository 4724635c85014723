// What a session is made from, and the limits that it lives within.
#ifndef CAGEFIT_SERVER_SESSION_SESSION_CONFIG_H_
#define CAGEFIT_SERVER_SESSION_SESSION_CONFIG_H_

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "core/codec/draco_codec.h"
#include "core/fit/fit_options.h"
#include "core/fit/tolerance_fit.h"
#include "core/image/camera.h"
#include "core/mesh/control_mesh.h"
#include "server/session/priority.h"
#include "server/session/template_maker.h"

namespace cagefit::server {

enum class DeltaEncoding { kPacked, kDraco };

// Fixed when the session is made; every fit reads it.
struct SessionConfig {
  std::string name;  // for people; at most kMaxNameBytes
  Priority priority = Priority::kLive;
  FitOptions fit;
  double quantum = 1e-5;  // of the first target's diagonal; 1e-9 to 1e-2, or 0: float32 positions
  DeltaEncoding delta_encoding = DeltaEncoding::kPacked;
  uint32_t key_interval = 100;  // a key frame at least every so many frames; 1 to 100,000

  std::vector<Camera>
      cameras;  // that masks of frames are of; at most kMaxCameras, named differently

  // The first frame refines the template as this says (fit/tolerance_fit.h); not set: as it is.
  std::optional<ToleranceOptions> tolerance;

  // Without a control mesh, the first frame makes one as make_template says.
  std::optional<ControlMesh> control_mesh;
  TemplateRequest make_template;

  static constexpr size_t kMaxNameBytes = 200;
  static constexpr size_t kMaxCameras = 64;
  // Control vertices that tolerance mode starts from where the client names no number.
  static constexpr int32_t kToleranceStartVertices = 200;

  // INVALID_ARGUMENT naming field, value and range.
  absl::Status Validate() const;
};

// Per-server limits that sessions and their frames are held against.
struct SessionLimits {
  DecodeLimits decode;
  int64_t max_frame_bytes = 64 << 20;  // encoded
  int32_t max_control_vertices = 200'000;
  int64_t max_frames = 1'000'000;                  // answered frames of a session
  int64_t max_history_bytes = int64_t{256} << 20;  // stored replies of a session
  int64_t max_surface_triangles = 5'000'000;       // of a refined surface that is sent
  int64_t max_camera_pixels = int64_t{128} << 20;  // of all cameras of a session together
};

}  // namespace cagefit::server

#endif  // CAGEFIT_SERVER_SESSION_SESSION_CONFIG_H_
