// Certificates and tokens that change while streams run. CAGEFIT_ROTATIONS says how often.
#include <gmock/gmock.h>
#include <grpcpp/grpcpp.h>
#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>
#include <thread>

#include "absl/strings/escaping.h"
#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "cagefit/v1/fitting.grpc.pb.h"
#include "server/session/digest.h"
#include "tests/server/log_lines.h"
#include "tests/server/running_server.h"
#include "tests/server/tls_folder.h"

namespace cagefit::server {
namespace {

using client::ClientCredentials;
using client::FitClient;
using ::testing::HasSubstr;
using testing::LogLines;
using ::testing::Not;
using testing::RunningServer;
using testing::TlsFolder;

int Rotations() {
  const char* text = std::getenv("CAGEFIT_ROTATIONS");
  return text == nullptr ? 5 : std::atoi(text);
}

std::unique_ptr<FitClient> Connect(const std::string& address,
                                   const ClientCredentials& credentials) {
  client::ClientOptions options;
  options.address = address;
  options.credentials = credentials;
  auto client = FitClient::Connect(options);
  EXPECT_TRUE(client.ok()) << client.status();
  return *std::move(client);
}

// One stream that sends frame after frame until it is destroyed, and ends well.
class LiveStream {
 public:
  LiveStream(const std::string& address, const ClientCredentials& credentials)
      : client_(Connect(address, credentials)),
        id_(client_->CreateSession(testing::CageRequest())->session_id()),
        stream_(client_->OpenStream(id_).value()),
        thread_([this] { Work(); }) {}
  ~LiveStream() {
    ending_ = true;
    thread_.join();
    EXPECT_EQ(client_->GetSession(id_)->epoch(), 1u);
    EXPECT_GT(answered_, 0u);
  }
  // Returns once the answer to a frame has come that was not sent yet.
  void WaitForAnswer() const {
    const uint64_t now = answered_;
    while (answered_ < now + 2 && !broken_) absl::SleepFor(absl::Milliseconds(1));
  }

 private:
  void Work() {
    while (!ending_ && !::testing::Test::HasFailure()) {
      const uint64_t number = answered_;
      EXPECT_TRUE(stream_->Send(testing::OutgoingMovingFrame(number)).ok());
      const client::FittedFrame frame = testing::ReceiveFrame(stream_.get());
      EXPECT_EQ(frame.reply.sequence_number(), number);
      EXPECT_EQ(frame.reply.outcome(), v1::OUTCOME_FITTED);
      ++answered_;
    }
    broken_ = true;
    EXPECT_TRUE(stream_->CloseSending().ok());
    const auto last = stream_->Receive();
    EXPECT_TRUE(last.ok() && !last->has_value()) << last.status();
  }

  std::unique_ptr<FitClient> client_;
  const std::string id_;
  std::unique_ptr<client::FrameStream> stream_;
  std::atomic<bool> ending_{false}, broken_{false};
  std::atomic<uint64_t> answered_{0};
  std::thread thread_;
};

// The common name that a new connection is shown. Every connection has to come about.
std::string ServerName(const std::string& address, const std::string& roots,
                       const cagefit::testing::CertificateAndKey& own) {
  grpc::SslCredentialsOptions options;
  options.pem_root_certs = roots;
  options.pem_cert_chain = own.certificate;
  options.pem_private_key = own.key;
  grpc::ChannelArguments arguments;
  arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
  const auto stub = v1::Fitting::NewStub(
      grpc::CreateCustomChannel(address, grpc::SslCredentials(options), arguments));
  grpc::ClientContext context;
  v1::ListSessionsResponse response;
  const grpc::Status status = stub->ListSessions(&context, {}, &response);
  EXPECT_TRUE(status.ok()) << status.error_message();
  const auto names = context.auth_context()->FindPropertyValues("x509_common_name");
  return names.empty() ? "" : std::string(names[0].data(), names[0].size());
}

TEST(RotationTest, CertificatesChangeUnderStreamsWithoutABreak) {
  TlsFolder folder;
  LogLines log;
  const RunningServer server(folder.OptionsWithClients(), log.log());
  const auto own = folder.authority().IssueClient("north");
  const LiveStream a(server.tcp(), folder.Client("north", own));
  const LiveStream b(server.tcp(), folder.Client("south", folder.authority().IssueClient("south")));
  for (int k = 0; k < Rotations() && !HasFailure(); ++k) {
    const std::string name = absl::StrCat("server ", k);
    folder.WriteServer(folder.authority().Issue(name));
    ASSERT_TRUE(log.WaitFor("certificate reloaded"));
    // Two writes: between them the server may have seen, and refused, half of the change.
    EXPECT_EQ(ServerName(server.tcp(), folder.authority().certificate(), own), name);
    a.WaitForAnswer();
  }
}

TEST(RotationTest, ABrokenCertificateLeavesTheOldOneInForce) {
  TlsFolder folder;
  LogLines log;
  const RunningServer server(folder.OptionsWithClients(), log.log());
  const auto own = folder.authority().IssueClient("north");
  const LiveStream stream(server.tcp(), folder.Client("north", own));
  const auto next = folder.authority().Issue("next");
  for (const std::string& broken : {next.key, std::string(), std::string("text")}) {
    folder.Write("server.key", broken);
    ASSERT_TRUE(log.WaitFor("certificate not reloaded, the old one stays in force"));
    EXPECT_EQ(ServerName(server.tcp(), folder.authority().certificate(), own), "server");
    stream.WaitForAnswer();
  }
  folder.WriteServer(next);
  ASSERT_TRUE(log.WaitFor("certificate reloaded"));
  EXPECT_EQ(ServerName(server.tcp(), folder.authority().certificate(), own), "next");
  EXPECT_THAT(log.All(), Not(HasSubstr("BEGIN")));
}

TEST(RotationTest, AClientOfAnAuthorityThatIsNoLongerTrustedGetsNoNewConnection) {
  TlsFolder folder;
  LogLines log;
  const RunningServer server(folder.OptionsWithClients(), log.log());
  const ClientCredentials north = folder.Client("north", folder.authority().IssueClient("north"));
  cagefit::testing::CertificateAuthority other("other");
  const ClientCredentials south = folder.Client("south", other.IssueClient("south"));
  EXPECT_TRUE(Connect(server.tcp(), north)->ListSessions().ok());
  const std::string ca = north.ca_file;
  folder.Write("server-ca.pem", folder.authority().certificate());
  folder.Write("ca.pem", other.certificate());
  ASSERT_TRUE(log.WaitFor("certificate reloaded"));
  client::ClientOptions options;
  options.address = server.tcp();
  options.connect_timeout = absl::Seconds(2);
  options.credentials = north;
  options.credentials.ca_file = absl::StrCat(ca.substr(0, ca.rfind('/')), "/server-ca.pem");
  auto client = FitClient::Connect(options);
  EXPECT_FALSE(client.ok() && (*client)->ListSessions().ok());
  options.credentials.cert_file = south.cert_file;
  options.credentials.key_file = south.key_file;
  client = FitClient::Connect(options);
  ASSERT_TRUE(client.ok()) << client.status();
  EXPECT_TRUE((*client)->ListSessions().ok());
}

// ---- Tokens ----

std::string Line(const std::string& name, const std::string& token) {
  const Digest digest = Sha256(token);
  return absl::StrCat(name, " ",
                      absl::BytesToHexString(absl::string_view(
                          reinterpret_cast<const char*>(digest.data()), digest.size())),
                      "\n");
}

ClientCredentials WithToken(const std::string& file) {
  ClientCredentials credentials;
  credentials.token_file = file;
  return credentials;
}

TEST(RotationTest, TokensChangeUnderStreamsWithoutABreak) {
  TlsFolder folder;
  LogLines log;
  ServerOptions options;
  options.tokens = folder.Write("tokens", Line("north", "steady"));
  const RunningServer server(options, log.log());
  const LiveStream stream(server.tcp(), WithToken(folder.Write("steady", "steady\n")));
  // One client for all: it reads its token again for every call.
  const std::string own_file = folder.Write("own", "steady\n");
  const auto client = Connect(server.tcp(), WithToken(own_file));
  std::string last;
  for (int k = 0; k < Rotations() && !HasFailure(); ++k) {
    const std::string token = absl::StrCat("token-", k);
    folder.Write("tokens", Line("north", "steady") + Line("north", token));
    ASSERT_TRUE(log.WaitFor("tokens reloaded count=2"));
    folder.Write("own", token);
    EXPECT_EQ(client->ListSessions()->size(), 1u);
    if (!last.empty()) {
      folder.Write("own", last);
      EXPECT_TRUE(absl::IsUnauthenticated(client->ListSessions().status()));
    }
    last = token;
    stream.WaitForAnswer();
  }
}

TEST(RotationTest, AStreamThatIsOpenOutlivesItsToken) {
  TlsFolder folder;
  LogLines log;
  ServerOptions options;
  options.tokens = folder.Write("tokens", Line("north", "steady"));
  const RunningServer server(options, log.log());
  const auto client = Connect(server.tcp(), WithToken(folder.Write("steady", "steady\n")));
  const std::string id = client->CreateSession(testing::CageRequest())->session_id();
  const auto stream = *client->OpenStream(id);
  folder.Write("tokens", "");
  ASSERT_TRUE(log.WaitFor("tokens reloaded count=0"));
  EXPECT_TRUE(absl::IsUnauthenticated(client->GetSession(id).status()));
  EXPECT_EQ(testing::FitMovingFrames(stream.get(), 0, 2).back().status, absl::OkStatus());
}

}  // namespace
}  // namespace cagefit::server
