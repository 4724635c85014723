#include "server/transport/status_convert.h"

#include <algorithm>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>

#include "absl/time/clock.h"
#include "server/session/error_detail.h"

namespace cagefit::server {
namespace {

// Statuses and details travel as HTTP/2 headers, of which clients take 8 KiB.
constexpr size_t kMaxMessageBytes = 2000;
constexpr size_t kMaxPartBytes = 200;
// The client's clock ends the call a little before this one's does: deadlines are rounded up on the
// way.
constexpr absl::Duration kDeadlineSlack = absl::Milliseconds(100);

// Bytes of the UTF-8 character that `text` (not empty) begins with (RFC 3629); 0 when it is none.
size_t CharacterBytes(absl::string_view text) {
  const auto byte = [&text](size_t k) { return static_cast<uint8_t>(text[k]); };
  const uint8_t first = byte(0);
  if (first < 0x80) return 1;
  if (first < 0xC2 || first > 0xF4) return 0;
  const size_t bytes = first < 0xE0 ? 2 : first < 0xF0 ? 3 : 4;
  if (text.size() < bytes) return 0;
  // No longer than needed, no surrogates, nothing beyond U+10FFFF.
  const uint8_t least = first == 0xE0 ? 0xA0 : first == 0xF0 ? 0x90 : 0x80;
  const uint8_t most = first == 0xED ? 0x9F : first == 0xF4 ? 0x8F : 0xBF;
  if (byte(1) < least || byte(1) > most) return 0;
  for (size_t k = 2; k < bytes; ++k) {
    if ((byte(k) & 0xC0) != 0x80) return 0;
  }
  return bytes;
}

// At most `most` bytes, cut between characters, and UTF-8 whatever a child process wrote: protobuf
// cannot read a message with another string in it.
std::string Cut(absl::string_view text, size_t most) {
  std::string cut;
  while (!text.empty()) {
    const size_t bytes = CharacterBytes(text);
    if (cut.size() + std::max<size_t>(bytes, 1) > most) break;
    if (bytes == 0) {
      cut += '?';
    } else {
      cut.append(text.data(), bytes);
    }
    text.remove_prefix(std::max<size_t>(bytes, 1));
  }
  return cut;
}

v1::ErrorDetail ToProto(const ErrorDetail& detail) {
  v1::ErrorDetail message;
  message.set_reason(Cut(detail.reason, kMaxPartBytes));
  message.set_field(Cut(detail.field, kMaxPartBytes));
  message.set_value(Cut(detail.value, kMaxPartBytes));
  message.set_limit(Cut(detail.limit, kMaxPartBytes));
  if (detail.retry_after > absl::ZeroDuration()) {
    absl::Duration rest;
    message.mutable_retry_after()->set_seconds(
        absl::IDivDuration(detail.retry_after, absl::Seconds(1), &rest));
    message.mutable_retry_after()->set_nanos(static_cast<int32_t>(absl::ToInt64Nanoseconds(rest)));
  }
  return message;
}

}  // namespace

grpc::Status ToGrpc(const absl::Status& status, grpc::CallbackServerContext* context) {
  if (status.ok()) return grpc::Status::OK;
  if (const std::optional<ErrorDetail> detail = DetailOf(status)) {
    context->AddTrailingMetadata(kErrorDetailTrailer, ToProto(*detail).SerializeAsString());
  }
  return grpc::Status(static_cast<grpc::StatusCode>(status.raw_code()),
                      Cut(status.message(), kMaxMessageBytes));
}

absl::Status NamingDeadline(const absl::Status& status, absl::Time deadline) {
  if (!absl::IsCancelled(status) || absl::Now() + kDeadlineSlack < deadline) return status;
  return absl::DeadlineExceededError("the deadline of the call has passed");
}

absl::Status CancelledCall(const grpc::CallbackServerContext& context) {
  return NamingDeadline(absl::CancelledError("the client cancelled the call"),
                        absl::FromChrono(context.deadline()));
}

v1::FrameError ToProto(const absl::Status& status) {
  v1::FrameError error;
  error.set_code(status.raw_code());
  error.set_message(Cut(status.message(), kMaxMessageBytes));
  if (const std::optional<ErrorDetail> detail = DetailOf(status)) {
    *error.mutable_detail() = ToProto(*detail);
  }
  return error;
}

absl::Status FromProto(const v1::FrameError& error) {
  absl::Status status(static_cast<absl::StatusCode>(error.code()), error.message());
  if (!error.has_detail()) return status;
  const v1::ErrorDetail& detail = error.detail();
  return WithDetail(std::move(status),
                    {detail.reason(), detail.field(), detail.value(), detail.limit(),
                     absl::Seconds(detail.retry_after().seconds()) +
                         absl::Nanoseconds(detail.retry_after().nanos())});
}

}  // namespace cagefit::server
