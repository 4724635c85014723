// What principals may have, over the network.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <fstream>

#include "absl/strings/escaping.h"
#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "server/session/digest.h"
#include "tests/server/running_server.h"
#include "tests/server/session/life_line.h"

namespace cagefit::server {
namespace {

using client::FitClient;
using testing::CageRequest;
using ::testing::HasSubstr;
using testing::OutgoingMovingFrame;
using testing::ReasonOf;
using testing::ReceiveFrame;
using testing::RunningServer;

class QuotaTest : public ::testing::Test {
 protected:
  // `quotas` are north's; south has none.
  void Start(const std::string& quotas, ServerOptions options = ServerOptions()) {
    options.tokens = folder_.path() + "/tokens";
    std::ofstream(options.tokens) << Line("north") << quotas << "\n" << Line("south") << "\n";
    server_ = std::make_unique<RunningServer>(options);
    north_ = Connect("north");
    south_ = Connect("south");
  }
  static std::string Line(const std::string& name) {
    const Digest digest = Sha256(name);
    return absl::StrCat(name, " ",
                        absl::BytesToHexString(absl::string_view(
                            reinterpret_cast<const char*>(digest.data()), digest.size())),
                        " ");
  }
  std::unique_ptr<FitClient> Connect(const std::string& name) {
    client::ClientOptions options;
    options.address = server_->unix_socket();
    options.credentials.token_file = folder_.path() + "/" + name;
    std::ofstream(options.credentials.token_file) << name;
    return *FitClient::Connect(options);
  }
  std::unique_ptr<client::FrameStream> OpenStream(FitClient* client,
                                                  const v1::CreateSessionRequest& request) {
    const auto session = client->CreateSession(request);
    EXPECT_TRUE(session.ok()) << session.status();
    return *client->OpenStream(session->session_id());
  }

  PrivateFolder folder_ = PrivateFolder::Create().value();
  std::unique_ptr<RunningServer> server_;
  std::unique_ptr<FitClient> north_, south_;
};

TEST_F(QuotaTest, SessionsAreCountedPerPrincipal) {
  Start("sessions=1");
  const auto first = north_->CreateSession(CageRequest());
  ASSERT_TRUE(first.ok()) << first.status();
  const absl::Status refused = north_->CreateSession(CageRequest()).status();
  EXPECT_TRUE(absl::IsResourceExhausted(refused)) << refused;
  EXPECT_EQ(refused.message(), "sessions of north is 2; the limit is 1");
  EXPECT_TRUE(south_->CreateSession(CageRequest()).ok());
  EXPECT_TRUE(south_->CreateSession(CageRequest()).ok());
  ASSERT_TRUE(north_->DeleteSession(first->session_id()).ok());
  EXPECT_TRUE(north_->CreateSession(CageRequest()).ok());
}

TEST_F(QuotaTest, AStreamOverItsRateIsSlowedDownAndNotBroken) {
  const double frame_bytes = static_cast<double>(OutgoingMovingFrame(0).draco.size());
  // The session and the first ten frames fit into the first second's worth.
  const double rate = 10 * frame_bytes + CageRequest().ByteSizeLong();
  Start(absl::StrCat("bytes-per-second=", static_cast<int64_t>(rate)));
  const auto stream = OpenStream(north_.get(), CageRequest());
  const absl::Time start = absl::Now();
  constexpr int kFrames = 20;
  for (const auto& frame : testing::FitMovingFrames(stream.get(), 0, kFrames)) {
    EXPECT_EQ(frame.status, absl::OkStatus());
  }
  // But for the last two frames, which are read whole before their debt is waited for.
  EXPECT_GT(absl::ToDoubleSeconds(absl::Now() - start), (kFrames - 2) * frame_bytes / rate - 1);
  EXPECT_TRUE(stream->CloseSending().ok());
  EXPECT_TRUE(stream->Receive().ok());
}

TEST_F(QuotaTest, RequestsOverTheRateAreExhaustionAndOthersAreNotConcerned) {
  Start("bytes-per-second=100");
  const auto stream = OpenStream(north_.get(), CageRequest());  // more than ten seconds' worth
  v1::CreateSessionRequest large = CageRequest(2);
  ASSERT_GT(large.ByteSizeLong(), 4096u);
  const absl::Status unary = north_->CreateSession(large).status();
  const absl::Status streamed = north_->EvaluateLoss(v1::EvaluateLossRequest()).status();
  for (const absl::Status& refused : {unary, streamed}) {
    EXPECT_TRUE(absl::IsResourceExhausted(refused)) << refused;
    EXPECT_EQ(ReasonOf(refused), "RATE_EXCEEDED");
    EXPECT_THAT(std::string(refused.message()), HasSubstr("try again in"));
  }
  EXPECT_TRUE(south_->CreateSession(large).ok());
  EXPECT_EQ(north_->ListSessions()->size(), 1u);  // small requests pass
  stream->Cancel();                               // though nothing is read from it
  EXPECT_TRUE(absl::IsCancelled(stream->Receive().status()));
}

TEST_F(QuotaTest, FitsOverTheShareWaitForThePrincipalsOwn) {
  // A session without a mesh waits in its template program until the test lets it go.
  testing::LifeLine life;
  const std::string program = folder_.path() + "/program", go = folder_.path() + "/go";
  ASSERT_EQ(mkfifo(go.c_str(), 0600), 0);
  std::ofstream(program) << "#!/bin/sh\nexec 3>" << life.path() << "\necho >&3\nread go < " << go
                         << "\nexit 1\n";
  ASSERT_EQ(chmod(program.c_str(), 0700), 0);
  ServerOptions options;
  options.template_program = program;
  options.threads = 4;
  options.fits = 3;
  Start("fits=1", options);
  v1::CreateSessionRequest slow;
  slow.mutable_make_template()->set_vertices(4);
  const auto first = OpenStream(north_.get(), slow);
  ASSERT_TRUE(first->Send(OutgoingMovingFrame(0)).ok());
  ASSERT_TRUE(life.WaitForStart());

  // North's second session waits though a worker is free, as south shows twice.
  const auto second = OpenStream(north_.get(), CageRequest());
  ASSERT_TRUE(second->Send(OutgoingMovingFrame(0)).ok());
  const auto others = OpenStream(south_.get(), CageRequest());
  for (const auto& frame : testing::FitMovingFrames(others.get(), 0, 2)) {
    EXPECT_EQ(frame.status, absl::OkStatus());
  }
  const auto sessions = north_->ListSessions();
  ASSERT_TRUE(sessions.ok()) << sessions.status();
  EXPECT_EQ(sessions->size(), 2u);
  for (const v1::Session& session : *sessions) {
    EXPECT_EQ(session.fitted_frames(), 0u);
  }

  std::ofstream(go) << "go\n";
  EXPECT_FALSE(ReceiveFrame(first.get()).status.ok());  // the program has failed
  EXPECT_EQ(ReceiveFrame(second.get()).status, absl::OkStatus());
}

}  // namespace
}  // namespace cagefit::server
