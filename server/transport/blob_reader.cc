#include "server/transport/blob_reader.h"

#include <utility>

#include "core/base/status.h"
#include "server/transport/status_convert.h"

namespace cagefit::server {
namespace {

constexpr int64_t kMaxBlobBytes = 64 << 20;

}  // namespace

BlobReader* BlobReader::Start(const ServiceState& state, grpc::CallbackServerContext* context,
                              const char* method, TakeFn take) {
  auto* reader = new BlobReader(state, context, method, std::move(take));
  const absl::Status entered = reader->Enter();
  if (entered.ok()) {
    reader->StartRead(&reader->chunk_);
  } else {
    reader->Finish(reader->record_.End(entered));
  }
  return reader;
}

BlobReader::BlobReader(const ServiceState& state, grpc::CallbackServerContext* context,
                       const char* method, TakeFn take)
    : state_(state),
      context_(context),
      record_(state, context, method),
      take_(std::move(take)),
      blob_(kMaxBlobBytes, state.budget) {}

absl::Status BlobReader::Enter() {
  ASSIGN_OR_RETURN(sessions_, state_.auth->Enter(*context_));
  return sessions_->CheckRate();
}

void BlobReader::OnReadDone(bool ok) {
  if (!ok) return End();
  sessions_->Receive(static_cast<int64_t>(chunk_.ByteSizeLong()));
  const absl::Status added = blob_.Add(chunk_.total_bytes(), chunk_.data());
  if (!added.ok()) return Finish(record_.End(added));
  StartRead(&chunk_);
}

void BlobReader::End() {
  const absl::Status complete = blob_.CheckComplete();
  if (!complete.ok()) return Finish(record_.End(complete));
  const absl::Status queued = state_.scheduler->queries.Run(context_->peer(), [this] {
    const absl::Status taken =
        context_->IsCancelled() ? CancelledCall(*context_) : take_(*sessions_, blob_.bytes());
    Finish(record_.End(taken));
  });
  if (!queued.ok()) Finish(record_.End(queued));
}

}  // namespace cagefit::server
