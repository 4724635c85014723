// A frame's reply as what the application gets.
#ifndef CAGEFIT_CLIENT_APPLY_REPLY_H_
#define CAGEFIT_CLIENT_APPLY_REPLY_H_

#include "absl/status/statusor.h"
#include "client/delta_decoder.h"
#include "client/fit_client.h"

namespace cagefit::client {

// Applies the delta of a fitted frame to `decoder`. DATA_LOSS as DeltaDecoder::Apply.
absl::StatusOr<FittedFrame> ApplyReply(v1::FrameReply reply, DeltaDecoder* decoder);

}  // namespace cagefit::client

#endif  // CAGEFIT_CLIENT_APPLY_REPLY_H_
