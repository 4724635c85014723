#include "server/transport/blob_reader.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "core/base/status.h"
#include "server/session/error_detail.h"
#include "server/transport/status_convert.h"

namespace cagefit::server {
namespace {

constexpr int64_t kMaxBlobBytes = 64 << 20;
constexpr size_t kMaxChunkBytes = 1 << 20;

}  // namespace

BlobReader* BlobReader::Start(const ServiceState& state, grpc::CallbackServerContext* context,
                              std::function<absl::Status(const std::string&)> take) {
  auto* reader = new BlobReader(state, context, std::move(take));
  reader->StartRead(&reader->chunk_);
  return reader;
}

BlobReader::BlobReader(const ServiceState& state, grpc::CallbackServerContext* context,
                       std::function<absl::Status(const std::string&)> take)
    : state_(state), context_(context), take_(std::move(take)), reservation_(state.budget) {}

void BlobReader::OnReadDone(bool ok) {
  if (!ok) return End();
  const absl::Status appended = Append();
  if (!appended.ok()) return Finish(ToGrpc(appended, context_));
  StartRead(&chunk_);
}

absl::Status BlobReader::Append() {
  if (blob_.empty()) total_bytes_ = chunk_.total_bytes();
  if (total_bytes_ > static_cast<uint64_t>(kMaxBlobBytes)) {
    return LimitExceeded("total_bytes", total_bytes_, kMaxBlobBytes);
  }
  if (chunk_.total_bytes() != total_bytes_) {
    return InvalidField("total_bytes", absl::StrCat(chunk_.total_bytes()),
                        absl::StrCat("the first chunk said ", total_bytes_));
  }
  const size_t bytes = chunk_.data().size();
  if (bytes == 0 || bytes > kMaxChunkBytes || bytes > total_bytes_ - blob_.size()) {
    return InvalidField("data", absl::StrCat(bytes, " bytes long"),
                        absl::StrCat("expected 1 to ", kMaxChunkBytes, ", in all ", total_bytes_));
  }
  RETURN_IF_ERROR(reservation_.Grow(static_cast<int64_t>(bytes)));
  blob_.append(chunk_.data());
  return absl::OkStatus();
}

void BlobReader::End() {
  if (blob_.size() != total_bytes_ || blob_.empty()) {
    return Finish(ToGrpc(InvalidField("data", absl::StrCat(blob_.size(), " bytes in all"),
                                      absl::StrCat("total_bytes is ", total_bytes_)),
                         context_));
  }
  const absl::Status queued = state_.scheduler->queries.Run(
      context_->peer(), [this] { Finish(ToGrpc(take_(blob_), context_)); });
  if (!queued.ok()) Finish(ToGrpc(queued, context_));
}

}  // namespace cagefit::server
