#include "server/transport/blob_writer.h"

#include <utility>

#include "server/transport/status_convert.h"

namespace cagefit::server {

BlobWriter* BlobWriter::Start(const ServiceState& state, grpc::CallbackServerContext* context,
                              const char* method, MakeFn make) {
  auto* writer = new BlobWriter(state, context, method);
  const absl::StatusOr<PrincipalSessions> sessions = state.auth->Enter(*context);
  if (!sessions.ok()) {
    writer->Begin(sessions.status());
    return writer;
  }
  const absl::Status queued = state.scheduler->queries.Run(
      context->peer(), [writer, sessions = *sessions, make = std::move(make)] {
        writer->Begin(writer->context_->IsCancelled() ? CancelledCall(*writer->context_)
                                                      : make(sessions));
      });
  if (!queued.ok()) writer->Begin(queued);
  return writer;
}

void BlobWriter::Begin(absl::StatusOr<std::string> blob) {
  const absl::Status taken = blob.ok() ? blob_.Set(*std::move(blob)) : blob.status();
  if (!taken.ok()) return Finish(record_.End(taken));
  StartWrite(blob_.Next());
}

void BlobWriter::OnWriteDone(bool ok) {
  if (!ok) return Finish(record_.End(absl::CancelledError("the client is gone")));
  if (blob_.is_sent()) return Finish(record_.End(absl::OkStatus()));
  StartWrite(blob_.Next());
}

}  // namespace cagefit::server
