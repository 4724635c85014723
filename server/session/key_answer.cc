#include "server/session/key_answer.h"

#include "core/base/status.h"

namespace cagefit::server {

absl::StatusOr<std::shared_ptr<const StoredFrame>> KeyAnswer(
    const SessionLedger& ledger, std::shared_ptr<const StoredFrame> answer) {
  if (answer->outcome != Outcome::kFitted || ledger.config().quantum == 0) return answer;
  ASSIGN_OR_RETURN(const SurfaceState state, ledger.StateOfFrame(answer->sequence_number));
  auto keyed = std::make_shared<StoredFrame>(*answer);
  ASSIGN_OR_RETURN(keyed->delta,
                   Encode(EncodeKey(state.q), answer->delta.grid, ledger.config().delta_encoding));
  return keyed;
}

}  // namespace cagefit::server
