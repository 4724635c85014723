#include "client/status_from_grpc.h"

#include <string>

#include "absl/strings/cord.h"

namespace cagefit::client {
namespace {

constexpr char kPayload[] = "cagefit.v1.ErrorDetail";
constexpr char kTrailer[] = "cagefit-error-detail-bin";

}  // namespace

absl::Status FromGrpc(const grpc::Status& status, const grpc::ClientContext& context) {
  if (status.ok()) return absl::OkStatus();
  absl::Status converted(static_cast<absl::StatusCode>(status.error_code()),
                         status.error_message());
  const auto& trailers = context.GetServerTrailingMetadata();
  const auto detail = trailers.find(kTrailer);
  if (detail != trailers.end()) {
    converted.SetPayload(
        kPayload, absl::Cord(absl::string_view(detail->second.data(), detail->second.size())));
  }
  return converted;
}

absl::Status FromProto(const v1::FrameError& error) {
  absl::Status status(static_cast<absl::StatusCode>(error.code()), error.message());
  if (error.has_detail()) {
    status.SetPayload(kPayload, absl::Cord(error.detail().SerializeAsString()));
  }
  return status;
}

std::optional<v1::ErrorDetail> DetailOf(const absl::Status& status) {
  const auto payload = status.GetPayload(kPayload);
  v1::ErrorDetail detail;
  if (!payload.has_value() || !detail.ParseFromString(std::string(*payload))) return std::nullopt;
  return detail;
}

}  // namespace cagefit::client
