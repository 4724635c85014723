#include "server/transport/blob_reader.h"

#include <utility>

#include "server/transport/status_convert.h"

namespace cagefit::server {
namespace {

constexpr int64_t kMaxBlobBytes = 64 << 20;

}  // namespace

BlobReader* BlobReader::Start(const ServiceState& state, grpc::CallbackServerContext* context,
                              std::function<absl::Status(const std::string&)> take) {
  auto* reader = new BlobReader(state, context, std::move(take));
  reader->StartRead(&reader->chunk_);
  return reader;
}

BlobReader::BlobReader(const ServiceState& state, grpc::CallbackServerContext* context,
                       std::function<absl::Status(const std::string&)> take)
    : state_(state),
      context_(context),
      take_(std::move(take)),
      blob_(kMaxBlobBytes, state.budget) {}

void BlobReader::OnReadDone(bool ok) {
  if (!ok) return End();
  const absl::Status added = blob_.Add(chunk_.total_bytes(), chunk_.data());
  if (!added.ok()) return Finish(ToGrpc(added, context_));
  StartRead(&chunk_);
}

void BlobReader::End() {
  const absl::Status complete = blob_.CheckComplete();
  if (!complete.ok()) return Finish(ToGrpc(complete, context_));
  const absl::Status queued = state_.scheduler->queries.Run(context_->peer(), [this] {
    const absl::Status taken =
        context_->IsCancelled() ? CancelledCall(*context_) : take_(blob_.bytes());
    Finish(ToGrpc(taken, context_));
  });
  if (!queued.ok()) Finish(ToGrpc(queued, context_));
}

}  // namespace cagefit::server
