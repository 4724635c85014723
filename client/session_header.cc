#include "client/session_header.h"

#include <algorithm>

#include "absl/strings/ascii.h"

namespace cagefit::client {

void AddSessionHeader(const std::string& session_id, grpc::ClientContext* context) {
  constexpr size_t kMostBytes = 128;
  const bool is_plain = !session_id.empty() && session_id.size() <= kMostBytes &&
                        std::all_of(session_id.begin(), session_id.end(), absl::ascii_isgraph);
  if (is_plain) context->AddMetadata(kSessionHeader, session_id);
}

}  // namespace cagefit::client
