// The seam through which what a journal keeps becomes bytes.
#ifndef CAGEFIT_SERVER_SESSION_RECORD_CODEC_H_
#define CAGEFIT_SERVER_SESSION_RECORD_CODEC_H_

#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "core/mesh/control_mesh.h"
#include "server/session/session_config.h"
#include "server/session/stored_frame.h"

namespace cagefit::server {

// Exact: what is decoded equals what was encoded to the bit. Later versions read what earlier ones
// wrote. Decoding is DATA_LOSS for bytes that are no such record. Thread-safe.
class RecordCodec {
 public:
  virtual ~RecordCodec() = default;

  // Every option in force, but not the control mesh.
  virtual std::string EncodeConfig(const SessionConfig& config) const = 0;
  virtual absl::StatusOr<SessionConfig> DecodeConfig(absl::string_view bytes) const = 0;

  virtual std::string EncodeMesh(const ControlMesh& mesh) const = 0;
  virtual absl::StatusOr<ControlMesh> DecodeMesh(absl::string_view bytes) const = 0;

  virtual std::string EncodeFrame(const StoredFrame& frame) const = 0;
  virtual absl::StatusOr<std::shared_ptr<const StoredFrame>> DecodeFrame(
      absl::string_view bytes) const = 0;
};

}  // namespace cagefit::server

#endif  // CAGEFIT_SERVER_SESSION_RECORD_CODEC_H_
