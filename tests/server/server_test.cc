#include "server/server.h"

#include <gmock/gmock.h>
#include <grpcpp/generic/generic_stub.h>
#include <grpcpp/grpcpp.h>
#include <gtest/gtest.h>

#include <future>
#include <set>
#include <vector>

#include "absl/strings/str_cat.h"
#include "cagefit/v1/fitting.grpc.pb.h"
#include "client/camera_to_proto.h"
#include "tests/server/running_server.h"
#include "tests/support/masks.h"

namespace cagefit::server {
namespace {

using cagefit::testing::FrameCage;
using cagefit::testing::MaskPng;
using cagefit::testing::SmallCamera;
using client::OutgoingFrame;
using testing::CageRequest;
using ::testing::HasSubstr;
using testing::OutgoingMovingFrame;
using testing::ReasonOf;
using testing::RunningServer;

v1::GetControlMeshRequest MeshOf(const std::string& session_id) {
  v1::GetControlMeshRequest request;
  request.set_session_id(session_id);
  return request;
}

// A unary call without generated code: of services whose messages this project does not compile.
std::string CallRaw(const std::string& address, const std::string& method,
                    const std::string& request_bytes) {
  grpc::GenericStub stub(grpc::CreateChannel(address, grpc::InsecureChannelCredentials()));
  grpc::ClientContext context;
  grpc::Slice slice(request_bytes);
  grpc::ByteBuffer request(&slice, 1), response;
  std::promise<grpc::Status> ended;
  stub.UnaryCall(&context, method, grpc::StubOptions(), &request, &response,
                 [&ended](grpc::Status status) { ended.set_value(std::move(status)); });
  const grpc::Status status = ended.get_future().get();
  if (!status.ok()) return "error: " + status.error_message();
  if (!response.TrySingleSlice(&slice).ok()) response.DumpToSingleSlice(&slice);
  return std::string(reinterpret_cast<const char*>(slice.begin()), slice.size());
}

// ---- Addresses ----

TEST(ServerTest, AnswersOnEveryAddress) {
  RunningServer server;
  for (const std::string& address : server->addresses()) {
    const auto client = client::FitClient::Connect({address});
    ASSERT_TRUE(client.ok()) << client.status();
    EXPECT_TRUE((*client)->ListSessions().ok());
  }
  EXPECT_THAT(server.tcp(), ::testing::MatchesRegex("127.0.0.1:[1-9][0-9]*"));
}

TEST(ServerTest, NamesAnAddressThatIsTaken) {
  RunningServer server;
  ServerOptions options;
  options.listen = {server.tcp()};
  const auto second = Server::Start(options, SilentLog());
  EXPECT_TRUE(absl::IsUnavailable(second.status())) << second.status();
  EXPECT_THAT(std::string(second.status().message()), HasSubstr(server.tcp()));
}

TEST(ServerTest, RefusesBadOptions) {
  ServerOptions options;
  options.max_points = 0;
  EXPECT_TRUE(absl::IsInvalidArgument(Server::Start(options, SilentLog()).status()));
}

TEST(ServerTest, ReflectionAnswersOnlyWhereItIsAskedFor) {
  const auto list_services = [](const RunningServer& server) {
    // ServerReflectionRequest.list_services
    return CallRaw(server.tcp(), "/grpc.reflection.v1alpha.ServerReflection/ServerReflectionInfo",
                   std::string("\x3a\x01*"));
  };
  ServerOptions options;
  options.reflection = true;
  EXPECT_THAT(list_services(RunningServer(options)), HasSubstr("cagefit.v1.Fitting"));
  EXPECT_THAT(list_services(RunningServer()), ::testing::StartsWith("error: "));
}

TEST(ServerTest, CompressedMessagesAreRefusedBeforeTheyAreInflated) {
  RunningServer server;
  for (const grpc_compression_algorithm algorithm : {GRPC_COMPRESS_DEFLATE, GRPC_COMPRESS_GZIP}) {
    const auto stub =
        v1::Fitting::NewStub(grpc::CreateChannel(server.tcp(), grpc::InsecureChannelCredentials()));
    grpc::ClientContext context;
    context.set_compression_algorithm(algorithm);
    v1::CreateSessionRequest request = CageRequest();
    request.set_name(std::string(200, 'n'));
    v1::Session session;
    const grpc::Status status = stub->CreateSession(&context, request, &session);
    EXPECT_EQ(status.error_code(), grpc::StatusCode::UNIMPLEMENTED) << status.error_message();
  }
  EXPECT_TRUE(server.Connect()->ListSessions()->empty());
}

// ---- Sessions ----

TEST(ServerTest, CreatesGetsListsAndDeletesSessions) {
  RunningServer server;
  const auto client = server.Connect();
  v1::CreateSessionRequest request = CageRequest();
  request.set_name("a rig");
  const auto session = client->CreateSession(request);
  ASSERT_TRUE(session.ok()) << session.status();
  EXPECT_EQ(session->name(), "a rig");
  EXPECT_EQ(session->control_vertices(), 42u);
  EXPECT_EQ(client->GetSession(session->session_id())->SerializeAsString(),
            session->SerializeAsString());
  ASSERT_EQ(client->ListSessions()->size(), 1u);
  EXPECT_EQ(client->ListSessions()->front().session_id(), session->session_id());
  EXPECT_EQ(client->DeleteSession(session->session_id()), absl::OkStatus());
  EXPECT_TRUE(client->ListSessions()->empty());
}

TEST(ServerTest, ListsSessionsPageByPage) {
  RunningServer server;
  const auto client = server.Connect();
  std::set<std::string> ids;
  for (int k = 0; k < 5; ++k) ids.insert(client->CreateSession(CageRequest())->session_id());
  const auto stub =
      v1::Fitting::NewStub(grpc::CreateChannel(server.tcp(), grpc::InsecureChannelCredentials()));
  std::vector<std::string> listed;
  v1::ListSessionsRequest request;
  request.set_page_size(2);
  for (const int expected : {2, 2, 1}) {
    grpc::ClientContext context;
    v1::ListSessionsResponse page;
    ASSERT_TRUE(stub->ListSessions(&context, request, &page).ok());
    ASSERT_EQ(page.sessions_size(), expected);
    for (const v1::Session& session : page.sessions()) listed.push_back(session.session_id());
    request.set_page_token(page.next_page_token());
    EXPECT_EQ(page.next_page_token().empty(), expected == 1);
  }
  EXPECT_EQ(listed, std::vector<std::string>(ids.begin(), ids.end()));
}

TEST(ServerTest, APageOfLargeSessionsIsCutBeforeItIsTooLarge) {
  RunningServer server;
  const auto client = server.Connect();
  v1::CreateSessionRequest request = CageRequest();
  for (int k = 0; k < 64; ++k) {
    *request.mutable_options()->add_cameras() =
        client::ToProto(SmallCamera(absl::StrCat(k, std::string(190, 'x'))));
  }
  const int sessions = 5 * (1 << 20) / static_cast<int>(request.options().ByteSizeLong());
  for (int k = 0; k < sessions; ++k) ASSERT_TRUE(client->CreateSession(request).ok());
  const auto listed = client->ListSessions();
  ASSERT_TRUE(listed.ok()) << listed.status();
  EXPECT_EQ(listed->size(), static_cast<size_t>(sessions));
}

TEST(ServerTest, ALargeControlMeshComesAndGoesByStream) {
  RunningServer server;
  const auto client = server.Connect();
  const ControlMesh cage = FrameCage(7);
  v1::CreateSessionRequest request;
  *request.mutable_control_mesh() = client::ToProto(cage);
  ASSERT_GT(request.ByteSizeLong(), size_t{4} << 20);
  const auto session = client->CreateSession(request);
  ASSERT_TRUE(session.ok()) << session.status();
  const auto mesh = client->GetControlMesh(MeshOf(session->session_id()));
  ASSERT_TRUE(mesh.ok()) << mesh.status();
  EXPECT_TRUE(mesh->vertices() == cage.vertices());
  EXPECT_TRUE(mesh->triangles() == cage.triangles());
}

TEST(ServerTest, AnUnknownSessionIsNotFound) {
  RunningServer server;
  const auto client = server.Connect();
  v1::GetSurfaceRequest surface;
  surface.set_session_id("nobody");
  for (const absl::Status& status :
       {client->GetSession("nobody").status(), client->DeleteSession("nobody"),
        client->GetControlMesh(MeshOf("nobody")).status(), client->GetSurface(surface).status(),
        client->OpenStream("nobody").status()}) {
    EXPECT_TRUE(absl::IsNotFound(status)) << status;
    EXPECT_THAT(std::string(status.message()), HasSubstr("nobody"));
    EXPECT_EQ(ReasonOf(status), "NO_SESSION");
  }
}

TEST(ServerTest, BadOptionsOfASessionAreNamed) {
  RunningServer server;
  v1::CreateSessionRequest request = CageRequest();
  request.mutable_options()->set_quantum(1);
  const absl::Status status = server.Connect()->CreateSession(request).status();
  EXPECT_TRUE(absl::IsInvalidArgument(status)) << status;
  EXPECT_EQ(client::DetailOf(status)->field(), "options.quantum");
  EXPECT_EQ(client::DetailOf(status)->value(), "1");
}

// ---- Limits ----

void ExpectLimit(const absl::Status& status, const std::string& field, const std::string& value,
                 const std::string& limit) {
  EXPECT_TRUE(absl::IsResourceExhausted(status)) << status;
  const auto detail = client::DetailOf(status);
  ASSERT_TRUE(detail.has_value()) << status;
  EXPECT_EQ(detail->reason(), "LIMIT_EXCEEDED");
  EXPECT_EQ(detail->field(), field);
  EXPECT_EQ(detail->value(), value);
  EXPECT_EQ(detail->limit(), limit);
}

TEST(ServerTest, TooManySessionsAreExhaustion) {
  ServerOptions options;
  options.max_sessions = 1;
  RunningServer server(options);
  const auto client = server.Connect();
  ASSERT_TRUE(client->CreateSession(CageRequest()).ok());
  ExpectLimit(client->CreateSession(CageRequest()).status(), "sessions", "2", "1");
}

TEST(ServerTest, TooManyControlVerticesAreExhaustion) {
  ServerOptions options;
  options.max_control_vertices = 41;
  RunningServer server(options);
  ExpectLimit(server.Connect()->CreateSession(CageRequest()).status(), "control vertices", "42",
              "41");
}

// The end of a stream that one frame is sent to, by a client that knows the session's id.
absl::Status EndAfter(const ServerOptions& options, const OutgoingFrame& frame) {
  RunningServer server(options);
  const auto client = server.Connect();
  const auto session = client->CreateSession(CageRequest());
  const auto stream = client->OpenStream(session->session_id());
  (void)(*stream)->Send(frame);  // may find that the stream has ended
  const absl::Status status = (*stream)->Receive().status();
  EXPECT_EQ(client->GetSession(session->session_id())->next_sequence_number(), 0u);
  return status;
}

TEST(ServerTest, TooLargeAFrameIsExhaustionAndConsumesNothing) {
  ServerOptions options;
  options.max_frame_mib = 1;
  OutgoingFrame frame;
  frame.draco.assign((1 << 20) + 1, 'x');
  ExpectLimit(EndAfter(options, frame), "header.total_bytes", "1048577", "1048576");
}

TEST(ServerTest, MasksAreHeldAgainstTheBudgetBeforeTheyAreDecoded) {
  ServerOptions options;
  options.max_buffered_mib = 1;
  RunningServer server(options);
  const auto client = server.Connect();
  v1::CreateSessionRequest request = CageRequest();
  Camera camera = SmallCamera("left");
  camera.width = camera.height = 300;  // 12 bytes for each of its pixels are too many
  *request.mutable_options()->add_cameras() = client::ToProto(camera);
  const auto stream = client->OpenStream(client->CreateSession(request)->session_id());
  OutgoingFrame frame = OutgoingMovingFrame(0);
  frame.masks = {{"left", MaskPng(300, 300)}};
  ASSERT_TRUE((*stream)->Send(frame).ok());
  const absl::Status status = (*stream)->Receive().status();
  EXPECT_TRUE(absl::IsResourceExhausted(status)) << status;
}

TEST(ServerTest, TooManyPointsAreExhaustionAndConsumeNothing) {
  ServerOptions options;
  options.max_points = 100;
  OutgoingFrame frame = OutgoingMovingFrame(0);
  frame.point_count = 500;
  ExpectLimit(EndAfter(options, frame), "header.point_count", "500", "100");
  frame.point_count = 0;  // found in the bytes
  const absl::Status status = EndAfter(options, frame);
  EXPECT_TRUE(absl::IsResourceExhausted(status)) << status;
  EXPECT_THAT(std::string(status.message()), HasSubstr("500"));
  EXPECT_THAT(std::string(status.message()), HasSubstr("100"));
}

}  // namespace
}  // namespace cagefit::server
