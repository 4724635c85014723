// Every RPC and field against requests that are wrong, over the wire.
#include <gmock/gmock.h>
#include <grpcpp/generic/generic_stub.h>
#include <grpcpp/grpcpp.h>
#include <gtest/gtest.h>

#include <future>
#include <map>
#include <set>

#include "client/status_from_grpc.h"
#include "tests/server/malformed/malformed_request.h"
#include "tests/server/running_server.h"

namespace cagefit::server::testing {

absl::Status EndOfStream(const Target& target, const std::vector<v1::FitFramesRequest>& messages) {
  grpc::ClientContext context;
  const auto stream = target.stub->FitFrames(&context);
  for (const v1::FitFramesRequest& message : messages) stream->Write(message);
  stream->WritesDone();
  v1::FitFramesReply reply;
  absl::Status rejected;
  while (stream->Read(&reply)) {
    if (reply.has_frame() && reply.frame().outcome() == v1::OUTCOME_REJECTED) {
      rejected.Update(client::FromProto(reply.frame().error()));
    }
  }
  const absl::Status ended = client::FromGrpc(stream->Finish(), context);
  return rejected.ok() ? ended : rejected;
}

v1::FitFramesRequest Open(const std::string& session_id) {
  v1::FitFramesRequest request;
  request.mutable_open()->set_session_id(session_id);
  return request;
}

v1::FitFramesRequest Header(uint64_t number, uint64_t total_bytes) {
  v1::FitFramesRequest request;
  request.mutable_header()->set_sequence_number(number);
  request.mutable_header()->set_total_bytes(total_bytes);
  return request;
}

v1::FitFramesRequest Chunk(const std::string& data) {
  v1::FitFramesRequest request;
  request.mutable_chunk()->set_data(data);
  return request;
}

namespace {

using ::testing::HasSubstr;

ServerOptions Limits() {
  ServerOptions options;
  options.max_frame_mib = kMaxFrameMib;
  options.max_points = kMaxPoints;
  options.max_control_vertices = kMaxControlVertices;
  return options;
}

class MalformedTest : public ::testing::Test {
 protected:
  MalformedTest() {
    const auto session = client_->CreateSession(CageRequest(0));
    EXPECT_TRUE(session.ok()) << session.status();
    target_ = {client_.get(), stub_.get(), session->session_id()};
    const auto stream = client_->OpenStream(session->session_id());
    EXPECT_EQ(FitMovingFrames(stream->get(), 0, 1)[0].status, absl::OkStatus());
  }

  // Each is refused as it has to be, and none changes the session.
  void ExpectAllRefused(const std::vector<MalformedRequest>& requests) {
    for (const MalformedRequest& request : requests) {
      SCOPED_TRACE(request.name);
      const absl::Status status = request.send(target_);
      EXPECT_EQ(status.code(), request.code) << status;
      EXPECT_THAT(std::string(status.message()), HasSubstr(request.message));
      const v1::ErrorDetail detail = client::DetailOf(status).value_or(v1::ErrorDetail());
      EXPECT_EQ(detail.reason(), request.reason) << status;
      EXPECT_EQ(detail.field(), request.field) << status;
      EXPECT_EQ(detail.value(), request.value) << status;
    }
    EXPECT_EQ(client_->GetSession(target_.session_id)->next_sequence_number(), 1u);
  }

  RunningServer server_{Limits()};
  std::unique_ptr<client::FitClient> client_ = server_.Connect();
  std::unique_ptr<v1::Fitting::Stub> stub_ = v1::Fitting::NewStub(
      grpc::CreateChannel(server_.unix_socket(), grpc::InsecureChannelCredentials()));
  Target target_;
};

TEST_F(MalformedTest, OptionsAreRefused) { ExpectAllRefused(MalformedOptions()); }
TEST_F(MalformedTest, MeshesAreRefused) { ExpectAllRefused(MalformedMeshes()); }
TEST_F(MalformedTest, CamerasAreRefused) { ExpectAllRefused(MalformedCameras()); }
TEST_F(MalformedTest, StreamsAreRefused) { ExpectAllRefused(MalformedStreams()); }
TEST_F(MalformedTest, FramesAreRejected) { ExpectAllRefused(MalformedFrames()); }
TEST_F(MalformedTest, QueriesAreRefused) { ExpectAllRefused(MalformedQueries()); }

absl::StatusCode CodeOfRawCall(const std::string& address, const std::string& method,
                               const std::string& bytes) {
  grpc::GenericStub stub(grpc::CreateChannel(address, grpc::InsecureChannelCredentials()));
  grpc::ClientContext context;
  grpc::Slice slice(bytes);
  grpc::ByteBuffer request(&slice, 1), response;
  std::promise<grpc::Status> ended;
  stub.UnaryCall(&context, "/cagefit.v1.Fitting/" + method, grpc::StubOptions(), &request,
                 &response, [&ended](grpc::Status status) { ended.set_value(std::move(status)); });
  return static_cast<absl::StatusCode>(ended.get_future().get().error_code());
}

TEST_F(MalformedTest, BytesThatAreNoMessageAreRefusedByEveryCall) {
  // gRPC itself answers UNIMPLEMENTED to a call whose message it cannot parse, and ends a stream at
  // it as if the client had. CreateSession parses its own.
  const std::map<std::string, absl::StatusCode> others = {
      {"CreateSession", absl::StatusCode::kInvalidArgument},
      {"FitFrames", absl::StatusCode::kInvalidArgument}};
  const std::string bad_utf8 = "\x0a\x02\xff\xfe";  // of field 1, a string everywhere
  for (const char* method : {"CreateSession", "GetSession", "DeleteSession", "GetControlMesh",
                             "GetSurface", "GetStencils", "FitFrames", "ListSessions"}) {
    for (const std::string& bytes :
         {std::string("\xff\xff\xff"), std::string("\x0a\x7f"), bad_utf8}) {
      if (std::string(method) == "ListSessions" && bytes == bad_utf8) continue;  // a number there
      const auto other = others.find(method);
      EXPECT_EQ(CodeOfRawCall(server_.unix_socket(), method, bytes),
                other != others.end() ? other->second : absl::StatusCode::kUnimplemented)
          << method;
    }
  }
  EXPECT_EQ(CodeOfRawCall(server_.unix_socket(), "NoSuchCall", ""),
            absl::StatusCode::kUnimplemented);
}

TEST(MalformedRequestTest, ThereAreMoreThanTwoHundredAndNoTwoAreTheSame) {
  std::multiset<std::string> names;
  for (const auto& list : {MalformedOptions(), MalformedMeshes(), MalformedCameras(),
                           MalformedStreams(), MalformedFrames(), MalformedQueries()}) {
    for (const MalformedRequest& request : list) names.insert(request.name);
  }
  RecordProperty("requests", static_cast<int>(names.size()));
  EXPECT_GE(names.size(), 200u);
  EXPECT_EQ(names.size(), std::set<std::string>(names.begin(), names.end()).size());
}

}  // namespace
}  // namespace cagefit::server::testing
