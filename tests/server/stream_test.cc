// Frames by a stream, and what is asked for beside it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <thread>
#include <vector>

#include "client/camera_to_proto.h"
#include "core/codec/draco_codec.h"
#include "server/server.h"
#include "server/transport/fit_frames_call.h"
#include "tests/server/running_server.h"
#include "tests/support/masks.h"

namespace cagefit::server {
namespace {

using cagefit::testing::FrameCage;
using cagefit::testing::MaskPng;
using cagefit::testing::SmallCamera;
using client::FittedFrame;
using client::OutgoingFrame;
using testing::CageRequest;
using testing::FitMovingFrames;
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

}  // namespace
}  // namespace cagefit::server
