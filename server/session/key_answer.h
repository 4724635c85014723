// Stored answers for somebody who does not know the state before them.
#ifndef CAGEFIT_SERVER_SESSION_KEY_ANSWER_H_
#define CAGEFIT_SERVER_SESSION_KEY_ANSWER_H_

#include <memory>

#include "absl/status/statusor.h"
#include "server/session/session_ledger.h"

namespace cagefit::server {

// The answer itself where it has no integers, as a rejected one, and one with positions. Otherwise
// the same answer with a key frame.
absl::StatusOr<std::shared_ptr<const StoredFrame>> KeyAnswer(
    const SessionLedger& ledger, std::shared_ptr<const StoredFrame> answer);

}  // namespace cagefit::server

#endif  // CAGEFIT_SERVER_SESSION_KEY_ANSWER_H_
