#include "client/embedded_server.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <filesystem>

#include "client/fit_client.h"
#include "client/mesh_from_proto.h"
#include "tests/support/frames.h"

namespace cagefit::client {
namespace {

using ::testing::StartsWith;

std::filesystem::path SocketOf(const EmbeddedServer& server) {
  return server.address().substr(std::string("unix:").size());
}

TEST(EmbeddedServerTest, FitsFrames) {
  const auto server = EmbeddedServer::Start(1);
  ASSERT_TRUE(server.ok()) << server.status();
  const auto client = FitClient::Connect({(*server)->address()});
  ASSERT_TRUE(client.ok()) << client.status();
  v1::CreateSessionRequest request;
  *request.mutable_control_mesh() = ToProto(cagefit::testing::FrameCage());
  const auto session = (*client)->CreateSession(request);
  ASSERT_TRUE(session.ok()) << session.status();
  const auto stream = (*client)->OpenStream(session->session_id());
  ASSERT_TRUE(stream.ok()) << stream.status();
  OutgoingFrame sent;
  sent.draco = cagefit::testing::FrameBytes(cagefit::testing::MovingCloud(0));
  ASSERT_TRUE((*stream)->Send(sent).ok());
  const auto frame = (*stream)->Receive();
  ASSERT_TRUE(frame.ok() && frame->has_value()) << frame.status();
  EXPECT_EQ((*frame)->status, absl::OkStatus());
  EXPECT_EQ((*frame)->control_vertices.cols(), 42);
}

TEST(EmbeddedServerTest, OnlyItsUserReachesTheSocketWhichGoesWithIt) {
  auto server = EmbeddedServer::Start(1);
  ASSERT_TRUE(server.ok()) << server.status();
  ASSERT_THAT((*server)->address(), StartsWith("unix:/"));
  const std::filesystem::path socket = SocketOf(**server);
  ASSERT_TRUE(std::filesystem::is_socket(socket));
  struct stat info;
  ASSERT_EQ(stat(socket.parent_path().c_str(), &info), 0);
  EXPECT_EQ(info.st_mode & 0777, 0700u);
  server->reset();
  EXPECT_FALSE(std::filesystem::exists(socket.parent_path()));
}

TEST(EmbeddedServerTest, SeveralRunSideBySide) {
  const auto a = EmbeddedServer::Start(1), b = EmbeddedServer::Start(1);
  ASSERT_TRUE(a.ok() && b.ok());
  EXPECT_NE((*a)->address(), (*b)->address());
  EXPECT_TRUE(FitClient::Connect({(*a)->address()}).ok());
  EXPECT_TRUE(FitClient::Connect({(*b)->address()}).ok());
}

TEST(EmbeddedServerTest, EndsWithAStreamStillOpen) {
  auto server = EmbeddedServer::Start(1);
  ASSERT_TRUE(server.ok()) << server.status();
  const auto client = FitClient::Connect({(*server)->address()});
  ASSERT_TRUE(client.ok()) << client.status();
  v1::CreateSessionRequest request;
  *request.mutable_control_mesh() = ToProto(cagefit::testing::FrameCage());
  const auto stream = (*client)->OpenStream((*client)->CreateSession(request)->session_id());
  ASSERT_TRUE(stream.ok()) << stream.status();
  server->reset();
  EXPECT_FALSE((*stream)->Receive().ok());
}

}  // namespace
}  // namespace cagefit::client
