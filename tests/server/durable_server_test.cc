// A server that ends and another that begins, on one store.
#include <grpcpp/grpcpp.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <optional>

#include "absl/time/clock.h"
#include "server/store/sql_journal.h"
#include "server/store/sqlite.h"
#include "tests/server/running_server.h"

namespace cagefit::server {
namespace {

using testing::CageRequest;
using testing::FitMovingFrames;
using testing::OutgoingMovingFrame;
using testing::ReasonOf;
using testing::ReceiveFrame;
using testing::RunningServer;

class DurableServerTest : public ::testing::Test {
 protected:
  std::string path() const { return folder_.path() + "/sessions.db"; }
  void Start() {
    server_.reset();
    ServerOptions options;
    options.store = "sqlite:" + path();
    server_.emplace(options);
  }
  std::string CreateSession() {
    return server_->Connect()->CreateSession(CageRequest())->session_id();
  }

  PrivateFolder folder_ = PrivateFolder::Create().value();
  std::optional<RunningServer> server_;
};

TEST_F(DurableServerTest, ASessionGoesOnBehindItsLastAnswer) {
  Start();
  const std::string id = CreateSession(), undisturbed = CreateSession();
  const auto expected =
      FitMovingFrames(server_->Connect()->OpenStream(undisturbed).value().get(), 0, 5);
  FitMovingFrames(server_->Connect()->OpenStream(id).value().get(), 0, 3);

  Start();
  const auto client = server_->Connect();
  const auto session = client->GetSession(id);
  ASSERT_TRUE(session.ok()) << session.status();
  EXPECT_EQ(session->next_sequence_number(), 3u);
  EXPECT_EQ(session->fitted_frames(), 3u);
  EXPECT_EQ(session->name(), "");
  EXPECT_EQ(client->ListSessions()->size(), 2u);
  const auto stream = client->OpenStream(id);
  ASSERT_TRUE(stream.ok()) << stream.status();
  EXPECT_EQ((*stream)->next_sequence_number(), 3u);
  const auto after = FitMovingFrames(stream->get(), 3, 5);
  for (size_t k = 0; k < after.size(); ++k) {
    EXPECT_EQ(after[k].control_vertices, expected[3 + k].control_vertices);
  }
}

TEST_F(DurableServerTest, FittedMeshesCanBePulledFromTheServerThatFollows) {
  Start();
  const std::string id = CreateSession();
  const auto fitted = FitMovingFrames(server_->Connect()->OpenStream(id).value().get(), 0, 3);
  Start();
  for (uint64_t number = 0; number < fitted.size(); ++number) {
    v1::GetControlMeshRequest request;
    request.set_session_id(id);
    request.set_sequence_number(number);
    const auto mesh = server_->Connect()->GetControlMesh(request);
    ASSERT_TRUE(mesh.ok()) << mesh.status();
    EXPECT_EQ(mesh->vertices(), fitted[number].control_vertices);
  }
}

TEST_F(DurableServerTest, ADeletedSessionStaysDeleted) {
  Start();
  const std::string id = CreateSession();
  ASSERT_TRUE(server_->Connect()->DeleteSession(id).ok());
  Start();
  EXPECT_EQ(ReasonOf(server_->Connect()->GetSession(id).status()), "NO_SESSION");
}

TEST_F(DurableServerTest, AStoreThatIsAwayIsUnavailableAndComesBackByItself) {
  Start();
  const std::string id = CreateSession();
  const auto client = server_->Connect();
  const auto stream = client->OpenStream(id).value();
  FitMovingFrames(stream.get(), 0, 1);
  std::filesystem::rename(path(), path() + ".away");
  std::filesystem::create_directory(path());

  ASSERT_TRUE(stream->Send(OutgoingMovingFrame(1)).ok());
  const absl::Status ended = stream->Receive().status();
  EXPECT_TRUE(absl::IsUnavailable(ended)) << ended;
  EXPECT_EQ(ReasonOf(ended), "STORE_UNAVAILABLE");
  const absl::Status refused = client->CreateSession(CageRequest()).status();
  EXPECT_EQ(ReasonOf(refused), "STORE_UNAVAILABLE") << refused;

  std::filesystem::remove(path());
  std::filesystem::rename(path() + ".away", path());
  absl::SleepFor(SqlJournal::kRetryInterval);
  const auto again = client->OpenStream(id);
  ASSERT_TRUE(again.ok()) << again.status();
  EXPECT_EQ((*again)->next_sequence_number(), 1u);
  EXPECT_TRUE(FitMovingFrames(again->get(), 1, 2)[0].status.ok());
}

TEST_F(DurableServerTest, AStoreOfAnotherProgramIsRefusedAtTheStart) {
  {
    const auto database = SqliteDatabase::Open(path()).value();
    ASSERT_TRUE(database->Execute("CREATE TABLE theirs (x)").ok());
  }
  ServerOptions options;
  options.listen = {"unix:" + folder_.path() + "/socket"};
  options.store = "sqlite:" + path();
  const absl::Status refused = Server::Start(options, SilentLog()).status();
  EXPECT_TRUE(absl::IsFailedPrecondition(refused)) << refused;
}

}  // namespace
}  // namespace cagefit::server
