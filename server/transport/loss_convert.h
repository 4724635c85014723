// What a training loop asks for, on the wire: stencils and losses.
#ifndef CAGEFIT_SERVER_TRANSPORT_LOSS_CONVERT_H_
#define CAGEFIT_SERVER_TRANSPORT_LOSS_CONVERT_H_

#include <optional>

#include "absl/status/statusor.h"
#include "cagefit/v1/fitting.pb.h"
#include "server/session/frame.h"
#include "server/session/session.h"
#include "server/session/stencil_export.h"

namespace cagefit::server {

v1::Stencils ToProto(const ExportedStencils& stencils);

struct LossQuery {
  std::string session_id;
  Points3d vertices;           // 3 x any number
  std::optional<Frame> frame;  // not decoded yet
};

// The frame's bytes are moved out. INVALID_ARGUMENT naming field and value.
absl::StatusOr<LossQuery> FromProto(v1::EvaluateLossRequest* request);

v1::EvaluateLossReply ToProto(const Loss& loss);

}  // namespace cagefit::server

#endif  // CAGEFIT_SERVER_TRANSPORT_LOSS_CONVERT_H_
