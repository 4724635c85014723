// What one message can do to the server: it takes at most 64 MB beyond what is accounted for, and
// at most 250 ms of processor time outside a fit.
#include <gmock/gmock.h>
#include <grpcpp/generic/generic_stub.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>
#include <functional>
#include <future>
#include <optional>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "client/mesh_from_proto.h"
#include "tests/load/load_client.h"
#include "tests/load/load_server.h"
#include "tests/support/frames.h"
#include "tests/support/sanitizer.h"

namespace cagefit::testing {
namespace {

constexpr double kMostBytes = kCostFactor * 64e6, kMostCpuMs = kCostFactor * 250;
constexpr size_t kChunkBytes = 1 << 20;

// `count` times a length-delimited field with nothing in it: two bytes on the wire.
std::string EmptyParts(int field, size_t count) {
  std::string wire;
  for (size_t k = 0; k < count; ++k) {
    wire += static_cast<char>(field << 3 | 2);
    wire += '\0';
  }
  return wire;
}

// A message as a length-delimited field of another.
std::string Part(int field, const std::string& message) {
  std::string wire(1, static_cast<char>(field << 3 | 2));
  for (size_t rest = message.size(); rest > 0 || wire.size() == 1; rest >>= 7) {
    wire += static_cast<char>((rest & 127) | (rest > 127 ? 128 : 0));
  }
  return wire + message;
}

std::string Chunked(const std::string& blob, size_t at) {
  v1::DataChunk chunk;
  chunk.set_total_bytes(blob.size());
  chunk.set_data(blob.substr(at, kChunkBytes));
  return chunk.SerializeAsString();
}

// Messages written to a method as they are, one call.
CallEnd CallRaw(const std::string& address, const std::string& method,
                const std::vector<std::string>& messages) {
  grpc::GenericStub stub(grpc::CreateChannel(address, grpc::InsecureChannelCredentials()));
  grpc::ClientContext context;
  context.set_deadline(std::chrono::system_clock::now() + std::chrono::seconds(60));
  grpc::CompletionQueue queue;
  const auto wait = [&queue] {
    void* tag = nullptr;
    bool ok = false;
    queue.Next(&tag, &ok);
    return ok;
  };
  const auto call = stub.PrepareCall(&context, "/cagefit.v1.Fitting/" + method, &queue);
  call->StartCall(nullptr);
  bool ok = wait();
  for (size_t k = 0; ok && k < messages.size(); ++k) {
    const grpc::Slice slice(messages[k]);
    call->Write(grpc::ByteBuffer(&slice, 1), nullptr);
    ok = wait();
  }
  if (ok) {
    call->WritesDone(nullptr);
    wait();
  }
  for (ok = true; ok;) {
    grpc::ByteBuffer reply;
    call->Read(&reply, nullptr);
    ok = wait();
  }
  grpc::Status status;
  call->Finish(&status, nullptr);
  wait();
  return EndOf(status, context);
}

CallEnd CallInChunks(const std::string& address, const std::string& method,
                     const std::string& blob) {
  std::vector<std::string> chunks;
  for (size_t at = 0; at < blob.size(); at += kChunkBytes) chunks.push_back(Chunked(blob, at));
  return CallRaw(address, method, chunks);
}

class HostileMessagesTest : public ::testing::Test {
 protected:
  HostileMessagesTest() : stub_(ConnectAlone(server_.address())) {
    CallEnd end;
    id_ = MakeSession(stub_.get(), 1, v1::PRIORITY_LIVE, &end);
    EXPECT_TRUE(end.ok()) << end;
    // What the first frame and the first large message cost once for all.
    const std::string frame = FrameBytes(MovingCloud(0));
    LoadStream stream(stub_.get(), id_);
    v1::StreamOpened opened;
    v1::FrameReply reply;
    EXPECT_TRUE(stream.Open(&opened) && stream.Send(0, frame) && stream.Receive(&reply));
    stream.CloseSending();
    EXPECT_TRUE(stream.Finish().ok());
  }

  // Runs `attack` and expects that it costs little. `accounted`: bytes that the server counts.
  CallEnd Measure(const std::function<CallEnd()>& attack, double accounted = 0) {
    const int64_t before = server_.resident_bytes();
    server_.ForgetPeak();
    const double cpu_before = server_.cpu_ms();
    const CallEnd end = attack();
    EXPECT_LE(server_.cpu_ms() - cpu_before, kMostCpuMs) << end;
    EXPECT_LE(static_cast<double>(server_.peak_bytes() - before), kMostBytes + accounted) << end;
    // And it serves on.
    grpc::ClientContext context;
    v1::GetSessionRequest request;
    v1::Session session;
    request.set_session_id(id_);
    EXPECT_TRUE(stub_->GetSession(&context, request, &session).ok());
    return end;
  }
  CallEnd MeasureCall(const std::string& method, const std::vector<std::string>& messages,
                      double accounted = 0) {
    return Measure([&] { return CallRaw(server_.address(), method, messages); }, accounted);
  }

  std::string Opening() const {
    v1::FitFramesRequest request;
    request.mutable_open()->set_session_id(id_);
    return request.SerializeAsString();
  }
  static std::string Header(size_t total_bytes) {
    v1::FitFramesRequest request;
    request.mutable_header()->set_sequence_number(1);
    request.mutable_header()->set_total_bytes(total_bytes);
    return request.SerializeAsString();
  }
  static std::string Chunk(const std::string& data) {
    v1::FitFramesRequest request;
    request.mutable_chunk()->set_data(data);
    return request.SerializeAsString();
  }

  LoadServer server_{{"--store", "memory", "--log-level", "error"}};
  std::unique_ptr<v1::Fitting::Stub> stub_;
  std::string id_;
};

// The largest message that is read at all.
constexpr size_t kLargest = (size_t{5} << 18) - 64;

TEST_F(HostileMessagesTest, MessagesAboveTheLimitAreRefusedUnread) {
  const std::string large(8 << 20, '\0');
  for (const char* method : {"CreateSession", "GetSession", "FitFrames", "EvaluateLoss"}) {
    EXPECT_EQ(MeasureCall(method, {large}).code, grpc::StatusCode::RESOURCE_EXHAUSTED) << method;
  }
}

TEST_F(HostileMessagesTest, ASessionOfManyEmptyCameras) {
  const std::string options = Part(2, EmptyParts(7, kLargest / 2 - 8));
  const CallEnd end = MeasureCall("CreateSession", {options});
  EXPECT_EQ(end.code, grpc::StatusCode::INVALID_ARGUMENT) << end;
}

TEST_F(HostileMessagesTest, ASessionOfManyEmptyCamerasByStream) {
  const std::string options = Part(2, EmptyParts(7, size_t{16} << 20));
  const CallEnd end =
      Measure([&] { return CallInChunks(server_.address(), "CreateSessionFromStream", options); },
              9.0 * static_cast<double>(options.size()));
  EXPECT_EQ(end.code, grpc::StatusCode::INVALID_ARGUMENT) << end;
}

TEST_F(HostileMessagesTest, FieldsThatNobodyKnows) {
  const std::string unknown = EmptyParts(15, kLargest / 2);
  for (const char* method :
       {"CreateSession", "GetSession", "ListSessions", "DeleteSession", "GetControlMesh",
        "GetSurface", "GetStencils", "EvaluateLoss", "CreateSessionFromStream", "FitFrames"}) {
    SCOPED_TRACE(method);
    MeasureCall(method, {unknown});
  }
}

TEST_F(HostileMessagesTest, AHeaderOfManyLandmarksOrMasks) {
  for (const int field : {6, 7}) {
    const std::string header = Part(2, EmptyParts(field, kLargest / 2 - 8));
    const CallEnd end = MeasureCall("FitFrames", {Opening(), header, Chunk("x")});
    EXPECT_NE(end.code, grpc::StatusCode::OK) << end;
  }
}

TEST_F(HostileMessagesTest, BytesThatAreNoMessage) {
  const std::string bytes(kLargest, '\xff');
  for (const std::vector<std::string>& messages : {std::vector{bytes}, {Opening(), bytes}}) {
    const CallEnd end = MeasureCall("FitFrames", messages);
    EXPECT_EQ(end.code, grpc::StatusCode::INVALID_ARGUMENT) << end;
    EXPECT_EQ(end.message, "message is not a FitFramesRequest; expected one, serialized");
  }
}

TEST_F(HostileMessagesTest, ALossOfManyLandmarks) {
  v1::EvaluateLossRequest request;
  request.set_session_id(id_);
  const std::string blob = request.SerializeAsString() + Part(3, EmptyParts(5, size_t{8} << 20));
  const CallEnd end = Measure([&] { return CallInChunks(server_.address(), "EvaluateLoss", blob); },
                              4.0 * static_cast<double>(blob.size()));
  EXPECT_EQ(end.code, grpc::StatusCode::INVALID_ARGUMENT) << end;
}

TEST_F(HostileMessagesTest, ALossOfManyVertices) {
  v1::EvaluateLossRequest request;
  request.set_session_id(id_);
  request.mutable_vertices()->Resize(1'000'000, 0.0);  // 8 MB
  const std::string blob = request.SerializeAsString();
  const CallEnd end = Measure([&] { return CallInChunks(server_.address(), "EvaluateLoss", blob); },
                              4.0 * static_cast<double>(blob.size()));
  EXPECT_EQ(end.code, grpc::StatusCode::INVALID_ARGUMENT) << end;
}

TEST_F(HostileMessagesTest, AMeshOfIndicesThatMeanNothing) {
  v1::CreateSessionRequest request;
  v1::ControlMesh* mesh = request.mutable_control_mesh();
  for (int k = 0; k < 3 * 20'000; ++k) mesh->add_vertices(k % 97);
  // Every triangle has one edge in common with all others.
  for (int k = 0; k < 100'000; ++k) {
    for (const int corner : {0, 1, 2 + k % 10'000}) mesh->add_triangles(corner);
  }
  for (int k = 0; k < 100'000; ++k) {
    mesh->add_crease_edges(0);
    mesh->add_crease_edges(1);
    mesh->add_corners(5);
  }
  const CallEnd end = MeasureCall("CreateSession", {request.SerializeAsString()});
  EXPECT_EQ(end.code, grpc::StatusCode::INVALID_ARGUMENT) << end;
}

TEST_F(HostileMessagesTest, AFrameThatClaimsMillionsOfPoints) {
  // The header of a sequential cloud, its number of points, and next to nothing behind it.
  std::string bomb("DRACO\x02\x03\x00\x00\x00\x00", 11);
  const int32_t points = 4'000'000;
  bomb.append(reinterpret_cast<const char*>(&points), sizeof(points));
  for (const size_t rest : {size_t{70}, size_t{20'000}, size_t{900'000}}) {
    SCOPED_TRACE(rest);
    std::string frame = bomb + std::string(rest, '\x01');
    MeasureCall("FitFrames", {Opening(), Header(frame.size()), Chunk(frame)});
  }
}

TEST_F(HostileMessagesTest, AFrameThatNeverComes) {
  const CallEnd end = MeasureCall("FitFrames", {Opening(), Header(64 << 20), Chunk("x")});
  EXPECT_EQ(end.code, grpc::StatusCode::INVALID_ARGUMENT) << end;
}

TEST_F(HostileMessagesTest, APageTokenOfAMegabyte) {
  v1::ListSessionsRequest request;
  request.set_page_token(std::string(1 << 20, 'x'));
  EXPECT_TRUE(MeasureCall("ListSessions", {request.SerializeAsString()}).ok());
}

}  // namespace
}  // namespace cagefit::testing
