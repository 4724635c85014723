#include "server/transport/incoming_blob.h"

#include "absl/strings/str_cat.h"
#include "core/base/status.h"
#include "server/session/error_detail.h"

namespace cagefit::server {
namespace {

constexpr size_t kMaxChunkBytes = 1 << 20;

}  // namespace

absl::Status IncomingBlob::Add(uint64_t total_bytes, const std::string& data) {
  if (bytes_.empty()) total_bytes_ = total_bytes;
  if (total_bytes_ > static_cast<uint64_t>(max_bytes_)) {
    return LimitExceeded("total_bytes", total_bytes_, max_bytes_);
  }
  if (total_bytes != total_bytes_) {
    return InvalidField("total_bytes", absl::StrCat(total_bytes),
                        absl::StrCat("the first chunk said ", total_bytes_));
  }
  if (data.empty() || data.size() > kMaxChunkBytes || data.size() > total_bytes_ - bytes_.size()) {
    return InvalidField("data", absl::StrCat(data.size(), " bytes long"),
                        absl::StrCat("expected 1 to ", kMaxChunkBytes, ", in all ", total_bytes_));
  }
  RETURN_IF_ERROR(reservation_.Grow(static_cast<int64_t>(data.size())));
  bytes_.append(data);
  return absl::OkStatus();
}

absl::Status IncomingBlob::CheckComplete() const {
  if (!bytes_.empty() && bytes_.size() == total_bytes_) return absl::OkStatus();
  return InvalidField("data", absl::StrCat(bytes_.size(), " bytes in all"),
                      absl::StrCat("total_bytes is ", total_bytes_));
}

}  // namespace cagefit::server
