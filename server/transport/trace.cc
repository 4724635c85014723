#include "server/transport/trace.h"

#include <algorithm>

#include "absl/strings/ascii.h"
#include "server/session/digest.h"

namespace cagefit::server {
namespace {

bool IsLowerHex(absl::string_view text) {
  return std::all_of(text.begin(), text.end(), [](char c) {
    return absl::ascii_isdigit(static_cast<unsigned char>(c)) || (c >= 'a' && c <= 'f');
  });
}

bool IsZero(absl::string_view text) {
  return text.find_first_not_of('0') == absl::string_view::npos;
}

}  // namespace

std::optional<std::string> ParseTraceparent(absl::string_view traceparent) {
  // version "-" trace id "-" parent id "-" flags: 2, 32, 16 and 2 digits. Later versions may go on
  // behind another dash.
  constexpr size_t kLength = 55;
  if (traceparent.size() < kLength) return std::nullopt;
  const absl::string_view version = traceparent.substr(0, 2);
  const absl::string_view trace_id = traceparent.substr(3, 32);
  const absl::string_view parent_id = traceparent.substr(36, 16);
  for (const absl::string_view part : {version, trace_id, parent_id, traceparent.substr(53, 2)}) {
    if (!IsLowerHex(part)) return std::nullopt;
  }
  for (const size_t dash : {2, 35, 52}) {
    if (traceparent[dash] != '-') return std::nullopt;
  }
  if (version == "ff" || IsZero(trace_id) || IsZero(parent_id)) return std::nullopt;
  if (traceparent.size() > kLength && (version == "00" || traceparent[kLength] != '-')) {
    return std::nullopt;
  }
  return std::string(trace_id);
}

std::string TraceIdOf(const grpc::CallbackServerContext& context) {
  const auto& metadata = context.client_metadata();
  if (metadata.count("traceparent") == 1) {
    const grpc::string_ref text = metadata.find("traceparent")->second;
    if (const auto id = ParseTraceparent({text.data(), text.size()})) return *id;
  }
  return RandomId();
}

}  // namespace cagefit::server
