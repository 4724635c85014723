#include "tests/load/load_client.h"

#include <sys/resource.h>

#include <algorithm>
#include <ostream>

#include "absl/strings/string_view.h"
#include "client/mesh_from_proto.h"
#include "tests/support/frames.h"

namespace cagefit::testing {
namespace {

constexpr size_t kChunkBytes = 1 << 20;

}  // namespace

std::unique_ptr<v1::Fitting::Stub> ConnectAlone(const std::string& address) {
  grpc::ChannelArguments arguments;
  arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
  return v1::Fitting::NewStub(
      grpc::CreateCustomChannel(address, grpc::InsecureChannelCredentials(), arguments));
}

void RaiseFileLimit() {
  rlimit limit = {};
  getrlimit(RLIMIT_NOFILE, &limit);
  limit.rlim_cur = limit.rlim_max;
  setrlimit(RLIMIT_NOFILE, &limit);
}

CallEnd EndOf(const grpc::Status& status, const grpc::ClientContext& context) {
  CallEnd end;
  end.code = status.error_code();
  end.message = status.error_message();
  const auto& trailers = context.GetServerTrailingMetadata();
  const auto found = trailers.find("cagefit-error-detail-bin");
  v1::ErrorDetail detail;
  if (found == trailers.end() ||
      !detail.ParseFromArray(found->second.data(), static_cast<int>(found->second.size()))) {
    return end;
  }
  end.reason = detail.reason();
  end.retry_after = absl::Seconds(detail.retry_after().seconds()) +
                    absl::Nanoseconds(detail.retry_after().nanos());
  return end;
}

std::ostream& operator<<(std::ostream& out, const CallEnd& end) {
  return out << "code " << end.code << " " << end.reason << ": " << end.message << " (retry after "
             << end.retry_after << ")";
}

std::string MakeSession(v1::Fitting::Stub* stub, int levels, v1::Priority priority, CallEnd* end) {
  v1::CreateSessionRequest request;
  *request.mutable_control_mesh() = client::ToProto(FrameCage(levels));
  request.mutable_options()->set_priority(priority);
  v1::Session session;
  grpc::ClientContext context;
  const grpc::Status status = stub->CreateSession(&context, request, &session);
  *end = EndOf(status, context);
  return session.session_id();
}

LoadStream::LoadStream(v1::Fitting::Stub* stub, const std::string& session_id, v1::FrameMode mode)
    : stream_(stub->FitFrames(&context_)) {
  v1::FitFramesRequest request;
  request.mutable_open()->set_session_id(session_id);
  request.mutable_open()->set_mode(mode);
  stream_->Write(request);
}

LoadStream::~LoadStream() {
  if (is_finished_) return;
  context_.TryCancel();
  Finish();
}

bool LoadStream::Open(v1::StreamOpened* opened) {
  v1::FitFramesReply reply;
  if (!stream_->Read(&reply)) return false;
  *opened = reply.opened();
  window_ = int64_t{opened->frames_in_flight()} + 1;
  return true;
}

bool LoadStream::Send(uint64_t number, const std::string& draco) {
  {
    std::unique_lock<std::mutex> lock(mutex_);
    room_.wait(lock, [this] { return has_ended_ || unanswered_ < window_; });
    if (has_ended_) return false;
    ++unanswered_;
  }
  v1::FitFramesRequest request;
  request.mutable_header()->set_sequence_number(number);
  request.mutable_header()->set_total_bytes(draco.size());
  if (!stream_->Write(request)) return false;
  absl::string_view rest = draco;
  for (; !rest.empty(); rest.remove_prefix(std::min(kChunkBytes, rest.size()))) {
    const absl::string_view chunk = rest.substr(0, kChunkBytes);
    request.mutable_chunk()->set_data(chunk.data(), chunk.size());
    if (!stream_->Write(request)) return false;
  }
  return true;
}

bool LoadStream::Receive(v1::FrameReply* reply) {
  v1::FitFramesReply message;
  const bool is_answer = stream_->Read(&message);
  {
    std::lock_guard<std::mutex> lock(mutex_);
    --unanswered_;
    has_ended_ |= !is_answer;
  }
  room_.notify_one();
  if (!is_answer) return false;
  reply->Swap(message.mutable_frame());
  return true;
}

CallEnd LoadStream::Finish() {
  is_finished_ = true;
  v1::FitFramesReply ignored;
  while (stream_->Read(&ignored)) {
  }
  const grpc::Status status = stream_->Finish();
  return EndOf(status, context_);
}

FrameLoop::FrameLoop(int frames, int64_t points) {
  for (int k = 0; k < frames; ++k) frames_.push_back(FrameBytes(MovingCloud(k, points)));
}

}  // namespace cagefit::testing
