// A Fitting service that fits nothing, but keeps its replies, and breaks its streams where a test
// wants it to.
#ifndef CAGEFIT_TESTS_CLIENT_FAKE_FITTING_H_
#define CAGEFIT_TESTS_CLIENT_FAKE_FITTING_H_

#include <grpc/grpc.h>
#include <grpcpp/grpcpp.h>
#include <gtest/gtest.h>

#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "cagefit/v1/fitting.grpc.pb.h"
#include "client/fit_client.h"
#include "core/base/private_folder.h"
#include "core/codec/vertex_delta.h"

namespace cagefit::client::testing {

constexpr int kFakeFramesInFlight = 2;

// Where a stream may break.
enum class Place { kBeforeOpened, kOpened, kInFrame, kBeforeFit, kBeforeReply, kAfterReply };

// The state that a frame with these bytes is "fitted" to.
inline GridPoints FakeState(const std::string& bytes) {
  const auto seed = static_cast<int32_t>(std::hash<std::string>()(bytes) & 0xffff);
  return GridPoints::NullaryExpr(3, 5, [seed](Eigen::Index r, Eigen::Index c) {
    return static_cast<int32_t>(seed * (r + 1) + c);
  });
}

// One session, whatever its id. A frame whose bytes begin with "bad" is rejected.
class FakeFitting : public v1::Fitting::Service {
 public:
  // Asked at every place, from the thread of the stream; not OK: the stream ends so.
  using Breaks = std::function<grpc::Status(Place, grpc::ServerContext*)>;

  explicit FakeFitting(Breaks breaks = nullptr) : breaks_(std::move(breaks)) {
    // Without a reference of its own, the next test would wait for gRPC to shut down first.
    static const bool keep_grpc = (grpc_init(), true);
    (void)keep_grpc;
    grpc::ServerBuilder builder;
    builder.AddListeningPort(address(), grpc::InsecureServerCredentials());
    builder.RegisterService(this);
    network_ = builder.BuildAndStart();
  }
  ~FakeFitting() override { Stop(); }

  void Stop() { network_->Shutdown(std::chrono::system_clock::now()); }
  std::string address() const { return "unix:" + folder_.path() + "/socket"; }
  std::unique_ptr<FitClient> Connect() const { return FitClient::Connect({address()}).value(); }

  int opened() const {
    std::lock_guard<std::mutex> lock(mutex_);
    return epoch_;
  }
  size_t answered() const {
    std::lock_guard<std::mutex> lock(mutex_);
    return answers_.size();
  }
  // A store that lost its last answers.
  void GoBackTo(size_t answers) {
    std::lock_guard<std::mutex> lock(mutex_);
    answers_.resize(answers);
  }

  grpc::Status FitFrames(
      grpc::ServerContext* context,
      grpc::ServerReaderWriter<v1::FitFramesReply, v1::FitFramesRequest>* stream) override {
    v1::FitFramesRequest request;
    if (!stream->Read(&request) || !request.has_open()) {
      return {grpc::StatusCode::INVALID_ARGUMENT, "open"};
    }
    if (auto status = At(Place::kBeforeOpened, context); !status.ok()) return status;
    v1::FitFramesReply reply;
    {
      std::lock_guard<std::mutex> lock(mutex_);
      reply.mutable_opened()->set_epoch(++epoch_);
      reply.mutable_opened()->set_next_sequence_number(answers_.size());
      reply.mutable_opened()->set_frames_in_flight(kFakeFramesInFlight);
    }
    stream->Write(reply);
    if (auto status = At(Place::kOpened, context); !status.ok()) return status;
    bool key = true;
    while (stream->Read(&request)) {
      const uint64_t number = request.header().sequence_number();
      const uint64_t total = request.header().total_bytes();
      std::string bytes;
      if (auto status = At(Place::kInFrame, context); !status.ok()) return status;
      while (bytes.size() < total && stream->Read(&request)) bytes += request.chunk().data();
      if (bytes.size() < total) return {grpc::StatusCode::INVALID_ARGUMENT, "cut off"};
      if (auto status = At(Place::kBeforeFit, context); !status.ok()) return status;
      if (auto status = Answer(number, bytes, &key, &reply); !status.ok()) return status;
      if (auto status = At(Place::kBeforeReply, context); !status.ok()) return status;
      stream->Write(reply);
      if (auto status = At(Place::kAfterReply, context); !status.ok()) return status;
    }
    return grpc::Status::OK;
  }

  grpc::Status GetReplies(grpc::ServerContext* context, const v1::GetRepliesRequest* request,
                          grpc::ServerWriter<v1::FrameReply>* writer) override {
    if (auto status = At(Place::kBeforeOpened, context); !status.ok()) return status;
    const uint64_t most = request->has_count() ? request->count() : answered();
    bool key = true;
    for (uint64_t k = request->first(); k < answered() && k - request->first() < most; ++k) {
      v1::FitFramesReply reply;
      if (auto status = Answer(k, BytesOf(k), &key, &reply); !status.ok()) return status;
      if (auto status = At(Place::kBeforeReply, context); !status.ok()) return status;
      writer->Write(reply.frame());
      if (auto status = At(Place::kAfterReply, context); !status.ok()) return status;
    }
    return grpc::Status::OK;
  }

 private:
  struct Stored {
    std::string bytes;
    bool is_fitted = false;
  };

  grpc::Status At(Place place, grpc::ServerContext* context) {
    return breaks_ ? breaks_(place, context) : grpc::Status::OK;
  }

  // As Session::Answer: once fitted, a frame gets what is stored.
  grpc::Status Answer(uint64_t number, const std::string& bytes, bool* key,
                      v1::FitFramesReply* message) {
    std::lock_guard<std::mutex> lock(mutex_);
    if (number > answers_.size()) return {grpc::StatusCode::OUT_OF_RANGE, "gap"};
    v1::FrameReply* reply = message->mutable_frame();
    reply->Clear();
    reply->set_sequence_number(number);
    const bool is_repeated = number < answers_.size();
    reply->set_repeated_reply(is_repeated);
    if (!is_repeated) answers_.push_back({bytes, !absl::StartsWith(bytes, "bad")});
    if (answers_[number].bytes != bytes) return {grpc::StatusCode::ALREADY_EXISTS, "other bytes"};
    if (!answers_[number].is_fitted) {
      reply->set_outcome(v1::OUTCOME_REJECTED);
      reply->mutable_error()->set_code(static_cast<int>(absl::StatusCode::kInvalidArgument));
      return grpc::Status::OK;
    }
    reply->set_outcome(v1::OUTCOME_FITTED);
    const GridPoints q = FakeState(bytes);
    const VertexDelta delta =
        *key || is_repeated ? EncodeKey(q) : EncodeDelta(StateBefore(number), q);
    *key = is_repeated;
    reply->mutable_delta()->set_key(delta.key);
    reply->mutable_delta()->set_quantum(0.5);
    reply->mutable_delta()->set_crc32c(delta.checksum);
    reply->mutable_delta()->mutable_packed()->Add(delta.values.data(),
                                                  delta.values.data() + delta.values.size());
    return grpc::Status::OK;
  }

  std::string BytesOf(uint64_t number) const {
    std::lock_guard<std::mutex> lock(mutex_);
    return answers_[number].bytes;
  }

  GridPoints StateBefore(uint64_t number) const {
    while (!answers_[--number].is_fitted) {
    }
    return FakeState(answers_[number].bytes);
  }

  const Breaks breaks_;
  PrivateFolder folder_ = PrivateFolder::Create().value();
  mutable std::mutex mutex_;
  std::vector<Stored> answers_;
  int epoch_ = 0;
  std::unique_ptr<grpc::Server> network_;
};

}  // namespace cagefit::client::testing

#endif  // CAGEFIT_TESTS_CLIENT_FAKE_FITTING_H_
