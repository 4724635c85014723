#include "server/transport/status_convert.h"

#include <optional>
#include <string>

#include "server/session/error_detail.h"

namespace cagefit::server {
namespace {

// Statuses and details travel as HTTP/2 headers, of which clients take 8 KiB.
constexpr size_t kMaxMessageBytes = 2000;
constexpr size_t kMaxPartBytes = 200;

std::string Cut(absl::string_view text, size_t most) { return std::string(text.substr(0, most)); }

v1::ErrorDetail ToProto(const ErrorDetail& detail) {
  v1::ErrorDetail message;
  message.set_reason(Cut(detail.reason, kMaxPartBytes));
  message.set_field(Cut(detail.field, kMaxPartBytes));
  message.set_value(Cut(detail.value, kMaxPartBytes));
  message.set_limit(Cut(detail.limit, kMaxPartBytes));
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

v1::FrameError ToProto(const absl::Status& status) {
  v1::FrameError error;
  error.set_code(status.raw_code());
  error.set_message(Cut(status.message(), kMaxMessageBytes));
  if (const std::optional<ErrorDetail> detail = DetailOf(status)) {
    *error.mutable_detail() = ToProto(*detail);
  }
  return error;
}

}  // namespace cagefit::server
