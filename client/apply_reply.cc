#include "client/apply_reply.h"

#include <utility>

#include "client/status_from_grpc.h"
#include "core/base/status.h"

namespace cagefit::client {

absl::StatusOr<FittedFrame> ApplyReply(v1::FrameReply reply, DeltaDecoder* decoder) {
  FittedFrame frame;
  frame.reply = std::move(reply);
  if (frame.reply.outcome() == v1::OUTCOME_FITTED) {
    RETURN_IF_ERROR(decoder->Apply(frame.reply.delta()));
  } else if (frame.reply.outcome() == v1::OUTCOME_SKIPPED) {
    frame.status = absl::AbortedError("skipped: a newer frame came before this one was begun");
  } else {
    frame.status = FromProto(frame.reply.error());
  }
  frame.control_vertices = decoder->vertices();
  return frame;
}

}  // namespace cagefit::client
