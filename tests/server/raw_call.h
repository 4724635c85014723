// Any call of any service by the bytes of its messages, and all that comes back.
#ifndef CAGEFIT_TESTS_SERVER_RAW_CALL_H_
#define CAGEFIT_TESTS_SERVER_RAW_CALL_H_

#include <grpcpp/generic/generic_stub.h>
#include <grpcpp/grpcpp.h>

#include <chrono>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "cagefit/v1/fitting.pb.h"

namespace cagefit::server::testing {

struct RawAnswer {
  grpc::Status status;
  std::string trailers;  // "name: value" lines in order of name
  v1::ErrorDetail detail;
  std::vector<std::string> messages;
};

inline grpc::ByteBuffer ToBuffer(const std::string& bytes) {
  const grpc::Slice slice(bytes);
  return grpc::ByteBuffer(&slice, 1);
}

inline std::string ToBytes(const grpc::ByteBuffer& buffer) {
  std::vector<grpc::Slice> slices;
  buffer.Dump(&slices);
  std::string bytes;
  for (const grpc::Slice& slice : slices) {
    bytes.append(reinterpret_cast<const char*>(slice.begin()), slice.size());
  }
  return bytes;
}

// Sends one message, closes, and reads to the end. A call that takes 30 s ends with
// DEADLINE_EXCEEDED.
inline RawAnswer CallRaw(const std::shared_ptr<grpc::Channel>& channel, const std::string& method,
                         const std::string& request,
                         const std::vector<std::pair<std::string, std::string>>& metadata) {
  grpc::GenericStub stub(channel);
  grpc::ClientContext context;
  context.set_deadline(std::chrono::system_clock::now() + std::chrono::seconds(30));
  for (const auto& [name, value] : metadata) context.AddMetadata(name, value);
  grpc::CompletionQueue queue;
  const auto step = [&queue] {
    void* tag = nullptr;
    bool ok = false;
    queue.Next(&tag, &ok);
    return ok;
  };
  const auto call = stub.PrepareCall(&context, method, &queue);
  call->StartCall(nullptr);
  RawAnswer answer;
  if (step()) {
    call->WriteLast(ToBuffer(request), grpc::WriteOptions(), nullptr);
    step();  // a call that was refused before takes none
    grpc::ByteBuffer buffer;
    for (call->Read(&buffer, nullptr); step(); call->Read(&buffer, nullptr)) {
      answer.messages.push_back(ToBytes(buffer));
      buffer.Clear();
    }
  }
  call->Finish(&answer.status, nullptr);
  step();
  for (const auto& [name, value] : context.GetServerTrailingMetadata()) {
    const std::string text(value.data(), value.size());
    answer.trailers += std::string(name.data(), name.size()) + ": " + text + "\n";
    if (name == "cagefit-error-detail-bin") answer.detail.ParseFromString(text);
  }
  queue.Shutdown();
  return answer;
}

}  // namespace cagefit::server::testing

#endif  // CAGEFIT_TESTS_SERVER_RAW_CALL_H_
