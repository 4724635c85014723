// A frame's answer on the wire.
#ifndef CAGEFIT_SERVER_TRANSPORT_REPLY_CONVERT_H_
#define CAGEFIT_SERVER_TRANSPORT_REPLY_CONVERT_H_

#include "cagefit/v1/fitting.pb.h"
#include "server/session/session.h"

namespace cagefit::server {

// Connectivity above this size is left out of the reply, which has to stay below 4 MiB.
inline constexpr size_t kMaxTemplateInReplyBytes = 1 << 20;

v1::Energies ToProto(const Energies& energies);

// Without template, not marked as repeated.
v1::FrameReply ToProto(const StoredFrame& frame);

v1::FrameReply ToProto(const FrameAnswer& answer, const SessionLedger& ledger);

}  // namespace cagefit::server

#endif  // CAGEFIT_SERVER_TRANSPORT_REPLY_CONVERT_H_
