// What a journal keeps, as protobuf.
#ifndef CAGEFIT_SERVER_TRANSPORT_RECORD_CONVERT_H_
#define CAGEFIT_SERVER_TRANSPORT_RECORD_CONVERT_H_

#include <memory>
#include <string>

#include "server/session/record_codec.h"

namespace cagefit::server {

// Configs are a v1::CreateSessionRequest without control mesh, meshes a v1::ControlMesh, frames a
// v1::FrameRecord.
class ProtoRecordCodec final : public RecordCodec {
 public:
  std::string EncodeConfig(const SessionConfig& config) const override;
  absl::StatusOr<SessionConfig> DecodeConfig(absl::string_view bytes) const override;
  std::string EncodeMesh(const ControlMesh& mesh) const override;
  absl::StatusOr<ControlMesh> DecodeMesh(absl::string_view bytes) const override;
  std::string EncodeFrame(const StoredFrame& frame) const override;
  absl::StatusOr<std::shared_ptr<const StoredFrame>> DecodeFrame(
      absl::string_view bytes) const override;
};

}  // namespace cagefit::server

#endif  // CAGEFIT_SERVER_TRANSPORT_RECORD_CONVERT_H_
