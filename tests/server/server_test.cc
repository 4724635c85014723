#include "server/server.h"

#include <gmock/gmock.h>
#include <grpcpp/generic/generic_stub.h>
#include <grpcpp/grpcpp.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <atomic>
#include <filesystem>
#include <fstream>
#include <future>
#include <set>
#include <thread>

#include "absl/strings/str_cat.h"
#include "cagefit/v1/fitting.grpc.pb.h"
#include "client/camera_to_proto.h"
#include "core/codec/draco_codec.h"
#include "server/transport/fit_frames_call.h"
#include "tests/server/running_server.h"
#include "tests/server/session/life_line.h"
#include "tests/support/masks.h"

namespace cagefit::server {
namespace {

using cagefit::testing::FrameBytes;
using cagefit::testing::FrameCage;
using cagefit::testing::MaskPng;
using cagefit::testing::MovingCloud;
using cagefit::testing::SmallCamera;
using cagefit::testing::SphereCloud;
using client::FittedFrame;
using client::OutgoingFrame;
using testing::CageRequest;
using testing::FitMovingFrames;
using ::testing::HasSubstr;
using testing::LifeLine;
using testing::OutgoingMovingFrame;
using testing::ReasonOf;
using testing::ReceiveFrame;
using testing::RunningServer;

v1::GetControlMeshRequest MeshOf(const std::string& session_id) {
  v1::GetControlMeshRequest request;
  request.set_session_id(session_id);
  return request;
}

v1::GetControlMeshRequest MeshOf(const std::string& session_id, uint64_t sequence_number) {
  v1::GetControlMeshRequest request = MeshOf(session_id);
  request.set_sequence_number(sequence_number);
  return request;
}

OutgoingFrame Png(uint64_t number) {
  OutgoingFrame frame;
  frame.sequence_number = number;
  frame.draco = std::string("\x89PNG\r\n\x1a\n\0\0\0\rIHDR", 16) + std::string(1000, 'x');
  return frame;
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

// ---- Frames ----

class StreamTest : public ::testing::Test {
 protected:
  void SetUp() override { StartSession(CageRequest()); }
  void StartSession(const v1::CreateSessionRequest& request) {
    const auto session = client_->CreateSession(request);
    ASSERT_TRUE(session.ok()) << session.status();
    id_ = session->session_id();
    Reopen();
  }
  void Reopen() {
    auto stream = client_->OpenStream(id_);
    ASSERT_TRUE(stream.ok()) << stream.status();
    stream_ = *std::move(stream);
  }
  Points3d ServersVertices(uint64_t number) {
    const auto mesh = client_->GetControlMesh(MeshOf(id_, number));
    EXPECT_TRUE(mesh.ok()) << mesh.status();
    return mesh.ok() ? mesh->vertices() : Points3d(3, 0);
  }

  RunningServer server_;
  std::unique_ptr<client::FitClient> client_ = server_.Connect();
  std::string id_;
  std::unique_ptr<client::FrameStream> stream_;
};

TEST_F(StreamTest, AnswersComeInFrameOrder) {
  const auto frames = FitMovingFrames(stream_.get(), 0, 20);
  for (uint64_t number = 0; number < 20; ++number) {
    EXPECT_EQ(frames[number].reply.sequence_number(), number);
    EXPECT_EQ(frames[number].reply.outcome(), v1::OUTCOME_FITTED);
    EXPECT_EQ(frames[number].reply.verdict(), v1::VERDICT_OK);
    EXPECT_LT(frames[number].reply.distances().rms_percent(), 1);
  }
  EXPECT_EQ(stream_->CloseSending(), absl::OkStatus());
  const auto end = stream_->Receive();
  ASSERT_TRUE(end.ok()) << end.status();
  EXPECT_FALSE(end->has_value());
}

TEST_F(StreamTest, TimestampsComeBack) {
  OutgoingFrame frame = OutgoingMovingFrame(0);
  frame.timestamp = absl::FromUnixNanos(1'700'000'000'123456789);
  ASSERT_TRUE(stream_->Send(frame).ok());
  const FittedFrame answer = ReceiveFrame(stream_.get());
  EXPECT_EQ(answer.reply.timestamp().seconds(), 1'700'000'000);
  EXPECT_EQ(answer.reply.timestamp().nanos(), 123456789);
}

TEST_F(StreamTest, CancelLetsASenderGoThatWaitsForRoom) {
  std::atomic<int> sent{0};
  std::thread sender([&] {
    // Nobody receives, so one frame more goes out than the server reads ahead, and no other.
    for (uint64_t number = 0; stream_->Send(OutgoingMovingFrame(number)).ok(); ++number) ++sent;
  });
  while (sent <= kFramesInFlight) std::this_thread::yield();
  stream_->Cancel();
  sender.join();
  EXPECT_EQ(sent, kFramesInFlight + 1);
}

TEST_F(StreamTest, APngIsRejectedAndTheStreamGoesOn) {
  ASSERT_TRUE(stream_->Send(OutgoingMovingFrame(0)).ok());
  const Points3d before = ReceiveFrame(stream_.get()).control_vertices;
  ASSERT_TRUE(stream_->Send(Png(1)).ok());
  const FittedFrame rejected = ReceiveFrame(stream_.get());
  EXPECT_EQ(rejected.reply.outcome(), v1::OUTCOME_REJECTED);
  EXPECT_TRUE(absl::IsInvalidArgument(rejected.status)) << rejected.status;
  EXPECT_EQ(ReasonOf(rejected.status), "BAD_FRAME");
  EXPECT_EQ(rejected.control_vertices, before);

  ASSERT_TRUE(stream_->Send(OutgoingMovingFrame(2)).ok());
  const FittedFrame next = ReceiveFrame(stream_.get());
  EXPECT_EQ(next.reply.outcome(), v1::OUTCOME_FITTED);
  EXPECT_EQ(next.control_vertices, ServersVertices(2));
  EXPECT_TRUE(absl::IsNotFound(client_->GetControlMesh(MeshOf(id_, 1)).status()));
  EXPECT_EQ(client_->GetSession(id_)->rejected_frames(), 1u);
}

// A session of two cameras, and a frame that `mask` says what of.
v1::CreateSessionRequest RequestWithCameras() {
  v1::CreateSessionRequest request = CageRequest();
  for (const char* name : {"left", "right"}) {
    *request.mutable_options()->add_cameras() = client::ToProto(SmallCamera(name));
  }
  return request;
}

TEST_F(StreamTest, MasksComeWithTheirFrame) {
  StartSession(RequestWithCameras());
  EXPECT_EQ(client_->GetSession(id_)->options().cameras_size(), 2);
  OutgoingFrame frame = OutgoingMovingFrame(0);
  frame.masks = {{"right", MaskPng(4, 3)}};
  ASSERT_TRUE(stream_->Send(frame).ok());
  EXPECT_EQ(ReceiveFrame(stream_.get()).status, absl::OkStatus());
  ASSERT_TRUE(stream_->Send(OutgoingMovingFrame(1)).ok());
  EXPECT_EQ(ReceiveFrame(stream_.get()).status, absl::OkStatus()) << "no view at all";

  OutgoingFrame bad = OutgoingMovingFrame(2);
  bad.masks = {{"left", MaskPng(4, 3)}, {"front", MaskPng(4, 3)}};
  ASSERT_TRUE(stream_->Send(bad).ok());
  const absl::Status refused = ReceiveFrame(stream_.get()).status;
  EXPECT_TRUE(absl::IsInvalidArgument(refused)) << refused;
  EXPECT_EQ(client::DetailOf(refused)->field(), "header.masks[1].camera");

  v1::EvaluateLossRequest loss;
  loss.set_session_id(id_);
  const Points3d V = FrameCage().vertices();
  loss.mutable_vertices()->Add(V.data(), V.data() + V.size());
  loss.mutable_frame()->set_data(frame.draco + frame.masks[0].png);
  v1::Mask* mask = loss.mutable_frame()->add_masks();
  mask->set_camera("right");
  mask->set_png_bytes(frame.masks[0].png.size());
  EXPECT_TRUE(client_->EvaluateLoss(loss).ok());
  mask->set_camera("front");
  EXPECT_EQ(client::DetailOf(client_->EvaluateLoss(loss).status())->field(),
            "frame.masks[0].camera");
}

TEST_F(StreamTest, LandmarksHoldTheSurface) {
  StartSession(CageRequest());
  OutgoingFrame frame = OutgoingMovingFrame(0);
  const Points3d plain = FrameCage().vertices();
  v1::Landmark& landmark = frame.landmarks.emplace_back();
  landmark.set_vertex(3);
  landmark.set_x(1.1 * plain(0, 3));
  landmark.set_y(1.1 * plain(1, 3));
  landmark.set_z(1.1 * plain(2, 3));
  ASSERT_TRUE(stream_->Send(frame).ok());
  const client::FittedFrame fitted = ReceiveFrame(stream_.get());
  ASSERT_EQ(fitted.status, absl::OkStatus());
  EXPECT_GT(fitted.reply.initial_energies().landmarks(), 0);
  EXPECT_LT(fitted.reply.final_energies().landmarks(),
            0.1 * fitted.reply.initial_energies().landmarks());

  OutgoingFrame bad = OutgoingMovingFrame(1);
  bad.landmarks.emplace_back().set_vertex(1'000'000);
  ASSERT_TRUE(stream_->Send(bad).ok());
  const absl::Status refused = ReceiveFrame(stream_.get()).status;
  EXPECT_TRUE(absl::IsInvalidArgument(refused)) << refused;
  EXPECT_EQ(client::DetailOf(refused)->field(), "header.landmarks[0].vertex");
  EXPECT_THAT(std::string(refused.message()),
              ::testing::StartsWith("header.landmarks[0].vertex is 1000000; the mesh has "));

  // The loss knows them, too.
  v1::EvaluateLossRequest loss;
  loss.set_session_id(id_);
  loss.mutable_vertices()->Add(plain.data(), plain.data() + plain.size());
  loss.mutable_frame()->set_data(frame.draco);
  *loss.mutable_frame()->add_landmarks() = landmark;
  const auto evaluated = client_->EvaluateLoss(loss);
  ASSERT_TRUE(evaluated.ok()) << evaluated.status();
  EXPECT_GT(evaluated->energies().landmarks(), 0);
  *loss.mutable_frame()->mutable_landmarks(0) = bad.landmarks[0];
  EXPECT_EQ(client::DetailOf(client_->EvaluateLoss(loss).status())->field(),
            "frame.landmarks[0].vertex");
}

TEST_F(StreamTest, ARepeatedFrameHasTheSameLandmarks) {
  StartSession(CageRequest());
  OutgoingFrame frame = OutgoingMovingFrame(0);
  frame.landmarks.emplace_back().set_vertex(3);
  for (const bool repeated : {false, true}) {
    ASSERT_TRUE(stream_->Send(frame).ok());
    EXPECT_EQ(ReceiveFrame(stream_.get()).reply.repeated_reply(), repeated);
  }
  frame.landmarks[0].set_x(1);
  ASSERT_TRUE(stream_->Send(frame).ok());
  EXPECT_TRUE(absl::IsAlreadyExists(stream_->Receive().status()));
}

TEST_F(StreamTest, ARepeatedFrameHasTheSameMasks) {
  StartSession(RequestWithCameras());
  OutgoingFrame frame = OutgoingMovingFrame(0);
  frame.masks = {{"right", MaskPng(4, 3)}};
  for (const bool repeated : {false, true}) {
    ASSERT_TRUE(stream_->Send(frame).ok());
    EXPECT_EQ(ReceiveFrame(stream_.get()).reply.repeated_reply(), repeated);
  }
  frame.masks[0].camera = "left";
  ASSERT_TRUE(stream_->Send(frame).ok());
  EXPECT_TRUE(absl::IsAlreadyExists(stream_->Receive().status()));
}

TEST_F(StreamTest, MeshesOfTemplateFrameAndTheLatestFit) {
  const auto frames = FitMovingFrames(stream_.get(), 0, 4);
  for (uint64_t number = 0; number < 4; ++number) {
    EXPECT_EQ(ServersVertices(number), frames[number].control_vertices);
  }
  EXPECT_EQ(client_->GetControlMesh(MeshOf(id_))->vertices(), frames[3].control_vertices);
  v1::GetControlMeshRequest of_template = MeshOf(id_);
  of_template.set_template_(true);
  EXPECT_EQ(client_->GetControlMesh(of_template)->vertices(), FrameCage().vertices());
  const absl::Status later = client_->GetControlMesh(MeshOf(id_, 4)).status();
  EXPECT_TRUE(absl::IsNotFound(later)) << later;
  EXPECT_EQ(ReasonOf(later), "FRAME_NOT_FITTED");
}

TEST_F(StreamTest, SurfacesOfAnyFrameAndLevel) {
  FitMovingFrames(stream_.get(), 0, 2);
  v1::GetSurfaceRequest request;
  request.set_session_id(id_);
  request.set_sequence_number(1);
  const auto bytes = client_->GetSurface(request);
  ASSERT_TRUE(bytes.ok()) << bytes.status();
  EXPECT_EQ(DecodeDracoMesh(*bytes, DecodeLimits())->triangles.cols(), 80 * 16);
  request.clear_sequence_number();
  EXPECT_EQ(*client_->GetSurface(request), *bytes);
  request.set_sequence_number(0);
  EXPECT_NE(*client_->GetSurface(request), *bytes);
  request.set_levels(0);
  EXPECT_EQ(DecodeDracoMesh(*client_->GetSurface(request), DecodeLimits())->triangles.cols(), 80);
  request.set_levels(6);
  EXPECT_TRUE(absl::IsInvalidArgument(client_->GetSurface(request).status()));
  request.set_levels(1);
  request.set_position_bits(0);
  EXPECT_TRUE(absl::IsInvalidArgument(client_->GetSurface(request).status()));
}

TEST_F(StreamTest, StencilsGiveTheServersSurface) {
  v1::GetStencilsRequest request;
  request.set_session_id(id_);
  request.set_levels(2);
  const auto stencils = client_->GetStencils(request);
  ASSERT_TRUE(stencils.ok()) << stencils.status();
  FitMovingFrames(stream_.get(), 0, 1);
  const Points3d V = ServersVertices(0);
  v1::GetSurfaceRequest surface;
  surface.set_session_id(id_);
  const TriangleMesh mesh = *DecodeDracoMesh(*client_->GetSurface(surface), DecodeLimits());
  ASSERT_EQ(stencils->rows(), mesh.vertices.cols());
  ASSERT_EQ(stencils->triangles_size(), mesh.triangles.size());
  for (uint32_t i = 0; i < stencils->rows(); ++i) {
    Eigen::Vector3d Q = Eigen::Vector3d::Zero();
    for (uint32_t k = stencils->row_begin(i); k < stencils->row_begin(i + 1); ++k) {
      Q += stencils->value(k) * V.col(stencils->column(k));
    }
    EXPECT_LT((Q - mesh.vertices.col(i)).norm(), 1e-6);
  }
  request.clear_levels();
  EXPECT_EQ(client_->GetStencils(request)->rows(), 162u);
  EXPECT_EQ(client_->GetStencils(request)->triangles_size(), 0);

  v1::CreateSessionRequest to_refine = CageRequest();
  to_refine.mutable_options()->set_tolerance(0.01);
  request.set_session_id(client_->CreateSession(to_refine)->session_id());
  const absl::Status early = client_->GetStencils(request).status();
  EXPECT_TRUE(absl::IsFailedPrecondition(early)) << early;
  EXPECT_EQ(ReasonOf(early), "NO_TEMPLATE_YET");
}

TEST_F(StreamTest, ALossBesideTheStreamChangesNothing) {
  const auto alone = FitMovingFrames(stream_.get(), 0, 20);
  StartSession(CageRequest());
  v1::EvaluateLossRequest request;
  request.set_session_id(id_);
  const Points3d V = FrameCage().vertices();
  request.mutable_vertices()->Add(V.data(), V.data() + V.size());
  std::atomic<bool> ended{false};
  int losses = 0;
  std::thread trainer([&] {
    while (!ended) losses += client_->EvaluateLoss(request).ok();
  });
  const auto beside = FitMovingFrames(stream_.get(), 0, 20);
  ended = true;
  trainer.join();
  EXPECT_GT(losses, 0);
  for (size_t k = 0; k < alone.size(); ++k) {
    EXPECT_EQ(beside[k].control_vertices, alone[k].control_vertices) << k;
  }
  const auto last = client_->EvaluateLoss(request);
  ASSERT_TRUE(last.ok()) << last.status();
  request.mutable_frame()->set_data(OutgoingMovingFrame(19).draco);
  EXPECT_EQ(client_->EvaluateLoss(request)->total(), last->total());
}

TEST_F(StreamTest, ANewerStreamEndsTheOlder) {
  ASSERT_TRUE(stream_->Send(OutgoingMovingFrame(0)).ok());
  ReceiveFrame(stream_.get());
  const auto older = std::move(stream_);
  Reopen();
  const absl::Status ended = older->Receive().status();
  EXPECT_TRUE(absl::IsAborted(ended)) << ended;
  EXPECT_EQ(ReasonOf(ended), "EPOCH_SUPERSEDED");

  EXPECT_EQ(stream_->next_sequence_number(), 1u);
  ASSERT_TRUE(stream_->Send(OutgoingMovingFrame(1)).ok());
  const FittedFrame frame = ReceiveFrame(stream_.get());
  EXPECT_EQ(frame.control_vertices, ServersVertices(1));
}

TEST_F(StreamTest, AFrameSentAgainGetsItsStoredReply) {
  const auto frames = FitMovingFrames(stream_.get(), 0, 3);
  Reopen();
  const auto again = FitMovingFrames(stream_.get(), 1, 5);
  for (const size_t k : {0u, 1u}) {
    EXPECT_TRUE(again[k].reply.repeated_reply());
    EXPECT_EQ(again[k].control_vertices, frames[k + 1].control_vertices);
  }
  for (const size_t k : {2u, 3u}) {
    EXPECT_FALSE(again[k].reply.repeated_reply());
    EXPECT_EQ(again[k].control_vertices, ServersVertices(k + 1));
  }
}

TEST_F(StreamTest, OtherBytesUnderAnOldNumberEndTheStream) {
  FitMovingFrames(stream_.get(), 0, 1);
  OutgoingFrame other = OutgoingMovingFrame(1);
  other.sequence_number = 0;
  ASSERT_TRUE(stream_->Send(other).ok());
  const absl::Status ended = stream_->Receive().status();
  EXPECT_TRUE(absl::IsAlreadyExists(ended)) << ended;
  EXPECT_EQ(ReasonOf(ended), "SEQUENCE_CONFLICT");
}

TEST_F(StreamTest, TheSessionForgetsAStreamThatLeaves) {
  stream_->Cancel();
  EXPECT_TRUE(absl::IsCancelled(stream_->Receive().status()));
  Reopen();
  EXPECT_EQ(client_->GetSession(id_)->epoch(), 2u);
  EXPECT_TRUE(client_->GetSession(id_)->stream_attached());
}

TEST_F(StreamTest, TwoClientsOnTwoSessionsDoNotDisturbEachOther) {
  const auto alone = FitMovingFrames(stream_.get(), 0, 30);
  std::vector<std::vector<FittedFrame>> together(2);
  std::vector<std::thread> threads;
  for (auto& frames : together) {
    threads.emplace_back([this, &frames] {
      const auto client = client::FitClient::Connect({server_.tcp()});
      const auto session = (*client)->CreateSession(CageRequest());
      const auto stream = (*client)->OpenStream(session->session_id());
      frames = FitMovingFrames(stream->get(), 0, 30);
    });
  }
  for (std::thread& thread : threads) thread.join();
  for (const auto& frames : together) {
    for (size_t k = 0; k < alone.size(); ++k) {
      EXPECT_EQ(frames[k].control_vertices, alone[k].control_vertices) << k;
    }
  }
}

// ---- Cancel and shutdown, at a fit that waits: its template program does what the test says ----

class WaitingFitTest : public ::testing::Test {
 protected:
  // The program tells when it runs, then waits for a line, then writes a tetrahedron.
  WaitingFitTest() {
    EXPECT_EQ(mkfifo(go_path().c_str(), 0600), 0);
    std::ofstream(program()) << "#!/bin/sh\nexec 3>" << life_.path() << "\necho >&3\nread go < "
                             << go_path()
                             << "\nprintf 'v 0 0 1\\nv 1 0 -1\\nv -1 1 -1\\nv -1 -1 -1\\n"
                                "f 1 2 3\\nf 1 3 4\\nf 1 4 2\\nf 2 4 3\\n' > \"$6\"\n";
    EXPECT_EQ(chmod(program().c_str(), 0700), 0);
    ServerOptions options;
    options.template_program = program();
    options.threads = 2;
    options.fits = 1;
    server_.emplace(options);
    client_ = server_->Connect();
  }
  std::string program() const { return folder_.path() + "/program"; }
  std::string go_path() const { return folder_.path() + "/go"; }
  void LetGo() { std::ofstream(go_path()) << "go\n"; }

  // A stream whose first frame is in work.
  std::unique_ptr<client::FrameStream> StartFit() {
    v1::CreateSessionRequest request;
    request.mutable_make_template()->set_vertices(4);
    const auto session = client_->CreateSession(request);
    EXPECT_TRUE(session.ok()) << session.status();
    id_ = session->session_id();
    auto stream = *client_->OpenStream(id_);
    EXPECT_TRUE(stream->Send(OutgoingMovingFrame(0)).ok());
    EXPECT_TRUE(life_.WaitForStart());
    return stream;
  }

  PrivateFolder folder_ = PrivateFolder::Create().value();
  LifeLine life_;
  std::optional<RunningServer> server_;
  std::unique_ptr<client::FitClient> client_;
  std::string id_;
};

TEST_F(WaitingFitTest, ATemplateIsMadeByTheProgram) {
  const auto stream = StartFit();
  LetGo();
  const FittedFrame frame = ReceiveFrame(stream.get());
  EXPECT_EQ(frame.status, absl::OkStatus());
  EXPECT_EQ(frame.reply.template_().triangles_size(), 12);
  EXPECT_EQ(frame.control_vertices.cols(), 4);
  EXPECT_EQ(client_->GetSession(id_)->control_vertices(), 4u);
}

TEST_F(WaitingFitTest, CancelEndsTheWorkAndConsumesNothing) {
  const auto stream = StartFit();
  stream->Cancel();
  EXPECT_TRUE(absl::IsCancelled(stream->Receive().status()));
  EXPECT_TRUE(life_.AllWritersEnd());

  // The only worker is free again, and the number still to be had.
  const auto other = client_->CreateSession(CageRequest());
  const auto other_stream = client_->OpenStream(other->session_id());
  EXPECT_EQ(FitMovingFrames(other_stream->get(), 0, 1)[0].status, absl::OkStatus());
  EXPECT_EQ((*client_->OpenStream(id_))->next_sequence_number(), 0u);
}

TEST_F(WaitingFitTest, DeletingTheSessionEndsTheWork) {
  const auto stream = StartFit();
  EXPECT_EQ(client_->DeleteSession(id_), absl::OkStatus());
  const absl::Status ended = stream->Receive().status();
  EXPECT_EQ(ReasonOf(ended), "SESSION_DELETED") << ended;
  EXPECT_TRUE(life_.AllWritersEnd());
}

TEST_F(WaitingFitTest, ShutdownAnswersTheFrameInWorkAndEndsWithUnavailable) {
  const auto stream = StartFit();
  std::thread shutdown([this] { (*server_)->Shutdown(absl::Seconds(60)); });
  LetGo();
  EXPECT_EQ(ReceiveFrame(stream.get()).status, absl::OkStatus());
  const absl::Status ended = stream->Receive().status();
  EXPECT_TRUE(absl::IsUnavailable(ended)) << ended;
  // The connection closes right behind the status: a client that still writes on it may see a
  // broken pipe (UNAVAILABLE too) instead of the reason.
  shutdown.join();
  EXPECT_FALSE(client_->GetSession(id_).ok());
}

TEST_F(WaitingFitTest, ShutdownCancelsWhatIsLeftAfterTheDrain) {
  const auto stream = StartFit();
  (*server_)->Shutdown(absl::ZeroDuration());
  EXPECT_FALSE(stream->Receive().ok());
  EXPECT_TRUE(life_.AllWritersEnd());
}

TEST(ServerTest, ShutdownEndsIdleStreamsWithUnavailable) {
  RunningServer server;
  const auto client = server.Connect();
  const auto session = client->CreateSession(CageRequest());
  const auto stream = client->OpenStream(session->session_id());
  ASSERT_TRUE(stream.ok()) << stream.status();
  server->Shutdown(absl::Seconds(60));
  const absl::Status ended = (*stream)->Receive().status();
  EXPECT_TRUE(absl::IsUnavailable(ended)) << ended;
  EXPECT_EQ(ReasonOf(ended), "DRAINING");
}

TEST(ServerTest, WhateverTheTemplateProgramSaysReachesTheClient) {
  const PrivateFolder folder = PrivateFolder::Create().value();
  ServerOptions options;
  options.template_program = folder.path() + "/program";
  std::ofstream(options.template_program) << "#!/bin/sh\nprintf 'bad: \\377' >&2\nexit 1\n";
  ASSERT_EQ(chmod(options.template_program.c_str(), 0700), 0);
  RunningServer server(options);
  const auto client = server.Connect();
  v1::CreateSessionRequest request;
  request.mutable_make_template()->set_vertices(100);
  const auto stream = client->OpenStream(client->CreateSession(request)->session_id());
  ASSERT_TRUE((*stream)->Send(OutgoingMovingFrame(0)).ok());
  const FittedFrame frame = ReceiveFrame(stream->get());
  EXPECT_TRUE(absl::IsInvalidArgument(frame.status)) << frame.status;
  EXPECT_THAT(std::string(frame.status.message()), HasSubstr("bad: ?"));
}

TEST(ServerTest, ATemplateWithoutItsProgramIsAFailedPrecondition) {
  ServerOptions options;
  options.template_program = "/nowhere/cagefit";
  RunningServer server(options);
  v1::CreateSessionRequest request;
  request.mutable_make_template()->set_vertices(100);
  const absl::Status status = server.Connect()->CreateSession(request).status();
  EXPECT_TRUE(absl::IsFailedPrecondition(status)) << status;
  EXPECT_EQ(ReasonOf(status), "TEMPLATE_PROGRAM_MISSING");
}

// ---- Long sequences: what the client adds up is what the server has ----

class SequenceTest : public StreamTest {
 protected:
  void SetUp() override {}

  void ExpectTheServersBits(const v1::SessionOptions& options, uint64_t count,
                            const std::set<uint64_t>& checked) {
    v1::CreateSessionRequest request = CageRequest();
    *request.mutable_options() = options;
    StartSession(request);
    const auto frames = FitMovingFrames(stream_.get(), 0, count);
    uint64_t keys = 0;
    for (uint64_t number = 0; number < count; ++number) {
      ASSERT_EQ(frames[number].reply.outcome(), v1::OUTCOME_FITTED) << number;
      ASSERT_EQ(frames[number].reply.sequence_number(), number);
      keys += frames[number].reply.delta().key();
    }
    const uint64_t interval = options.quantum() > 0 ? options.key_interval() : 1;
    EXPECT_EQ(keys, (count + interval - 1) / interval);
    for (const uint64_t number : checked) {
      EXPECT_EQ(frames[number].control_vertices, ServersVertices(number)) << number;
    }
    EXPECT_EQ(frames.back().control_vertices, client_->GetControlMesh(MeshOf(id_))->vertices());
  }
};

TEST_F(SequenceTest, ReproducesTheServersVerticesOverAThousandFrames) {
  v1::SessionOptions options;
  options.set_quantum(1e-5);
  options.set_key_interval(400);
  ExpectTheServersBits(options, 1000, {0, 1, 2, 399, 400, 401, 750, 998, 999});
}

TEST_F(SequenceTest, ReproducesTheServersVerticesFromDraco) {
  v1::SessionOptions options;
  options.set_quantum(1e-5);
  options.set_key_interval(20);
  options.set_delta_encoding(v1::DELTA_ENCODING_DRACO);
  ExpectTheServersBits(options, 50, {0, 1, 19, 20, 33, 49});
}

TEST_F(SequenceTest, ReproducesTheServersVerticesWithoutAQuantum) {
  v1::SessionOptions options;
  options.set_quantum(0);
  ExpectTheServersBits(options, 50, {0, 1, 19, 20, 33, 49});
}

}  // namespace
}  // namespace cagefit::server
