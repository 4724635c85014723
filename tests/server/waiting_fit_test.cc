// Cancel and shutdown at a fit that waits: its template program does what the test says.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <fstream>
#include <thread>

#include "server/server.h"
#include "tests/server/running_server.h"
#include "tests/server/session/life_line.h"

namespace cagefit::server {
namespace {

using client::FittedFrame;
using testing::CageRequest;
using testing::FitMovingFrames;
using ::testing::HasSubstr;
using testing::LifeLine;
using testing::OutgoingMovingFrame;
using testing::ReasonOf;
using testing::ReceiveFrame;
using testing::RunningServer;

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

}  // namespace
}  // namespace cagefit::server
