#include "server/transport/blob_writer.h"

#include <algorithm>
#include <utility>

#include "server/transport/status_convert.h"

namespace cagefit::server {
namespace {

constexpr size_t kChunkBytes = 1 << 20;

}  // namespace

BlobWriter* BlobWriter::Start(const ServiceState& state, grpc::CallbackServerContext* context,
                              std::function<absl::StatusOr<std::string>()> make) {
  auto* writer = new BlobWriter(context);
  const absl::Status queued =
      state.scheduler->queries.Run(context->peer(), [writer, make = std::move(make)] {
        writer->Begin(writer->context_->IsCancelled() ? absl::CancelledError("cancelled") : make());
      });
  if (!queued.ok()) writer->Begin(queued);
  return writer;
}

void BlobWriter::Begin(absl::StatusOr<std::string> blob) {
  if (!blob.ok()) return Finish(ToGrpc(blob.status(), context_));
  blob_ = *std::move(blob);
  chunk_.set_total_bytes(blob_.size());
  WriteNext();
}

void BlobWriter::WriteNext() {
  const size_t bytes = std::min(kChunkBytes, blob_.size() - sent_);
  chunk_.set_data(blob_.data() + sent_, bytes);
  sent_ += bytes;
  StartWrite(&chunk_);
}

void BlobWriter::OnWriteDone(bool ok) {
  if (!ok) return Finish(grpc::Status(grpc::StatusCode::CANCELLED, "the client is gone"));
  if (sent_ == blob_.size()) return Finish(grpc::Status::OK);
  WriteNext();
}

}  // namespace cagefit::server
