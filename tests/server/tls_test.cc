// TLS on the server's ports: who gets a connection, and as whom.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "tests/server/raw_call.h"
#include "tests/server/running_server.h"
#include "tests/server/tls_folder.h"

namespace cagefit::server {
namespace {

using cagefit::testing::CertificateAuthority;
using client::ClientCredentials;
using client::FitClient;
using testing::CageRequest;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using testing::ReasonOf;
using testing::RunningServer;
using testing::TlsFolder;

absl::StatusOr<std::unique_ptr<FitClient>> Connect(const std::string& address,
                                                   const ClientCredentials& credentials) {
  client::ClientOptions options;
  options.address = address;
  options.credentials = credentials;
  options.connect_timeout = absl::Seconds(2);
  return FitClient::Connect(options);
}

void ExpectRefused(const std::string& address, const ClientCredentials& credentials) {
  const auto client = Connect(address, credentials);
  // With TLS 1.3 a client learns that its certificate is refused after it has connected.
  const absl::Status status = client.ok() ? (*client)->ListSessions().status() : client.status();
  EXPECT_TRUE(absl::IsUnavailable(status)) << status;
}

class TlsTest : public ::testing::Test {
 protected:
  TlsFolder folder_;
};

TEST_F(TlsTest, AClientThatTrustsTheAuthorityIsServed) {
  const RunningServer server(folder_.Options());
  const auto client = Connect(server.tcp(), folder_.Trusting());
  ASSERT_TRUE(client.ok()) << client.status();
  EXPECT_TRUE((*client)->ListSessions().ok());
}

TEST_F(TlsTest, PortsWithTlsTakeNothingElse) {
  const RunningServer server(folder_.Options());
  ExpectRefused(server.tcp(), ClientCredentials());
}

TEST_F(TlsTest, UnixSocketsStayPlain) {
  const RunningServer server(folder_.OptionsWithClients());
  EXPECT_TRUE(server.Connect()->ListSessions().ok());
  const auto client = Connect(server.unix_socket(), folder_.Trusting());  // asks for it in vain
  ASSERT_TRUE(client.ok()) << client.status();
  EXPECT_TRUE((*client)->ListSessions().ok());
}

TEST_F(TlsTest, AClientThatTrustsAnotherAuthorityIsToldWhy) {
  const RunningServer server(folder_.Options());
  ClientCredentials credentials;
  credentials.ca_file = folder_.Write("other.pem", CertificateAuthority("other").certificate());
  const absl::Status status = Connect(server.tcp(), credentials).status();
  EXPECT_TRUE(absl::IsUnavailable(status)) << status;
  EXPECT_THAT(std::string(status.message()),
              ::testing::AnyOf(HasSubstr("CERTIFICATE_VERIFY_FAILED"),
                               HasSubstr("certificate verify failed")));
}

TEST_F(TlsTest, ANameOfSeveralAddressesIsListenedOn) {
  ServerOptions options = folder_.Options();
  options.listen = {"localhost:0"};
  const auto server = Server::Start(options, SilentLog());
  ASSERT_TRUE(server.ok()) << server.status();
  const auto client = Connect((*server)->addresses()[0], folder_.Trusting());
  ASSERT_TRUE(client.ok()) << client.status();
  EXPECT_TRUE((*client)->ListSessions().ok());
}

TEST_F(TlsTest, AnAddressThatIsTakenIsNamed) {
  const RunningServer server(folder_.Options());
  ServerOptions options = folder_.Options();
  options.listen = {server.tcp()};
  const absl::Status status = Server::Start(options, SilentLog()).status();
  EXPECT_TRUE(absl::IsUnavailable(status)) << status;
  EXPECT_THAT(std::string(status.message()), HasSubstr(server.tcp()));
}

// ---- Certificates of clients ----

TEST_F(TlsTest, WhereClientsNeedACertificateOnlyTheAuthoritysAreServed) {
  const RunningServer server(folder_.OptionsWithClients());
  ExpectRefused(server.tcp(), folder_.Trusting());
  CertificateAuthority other("other");
  ExpectRefused(server.tcp(), folder_.Client("stranger", other.IssueClient("north")));
  const auto client =
      Connect(server.tcp(), folder_.Client("north", folder_.authority().IssueClient("north")));
  ASSERT_TRUE(client.ok()) << client.status();
  EXPECT_TRUE((*client)->ListSessions().ok());
}

TEST_F(TlsTest, SessionsBelongToTheNameInTheCertificate) {
  const RunningServer server(folder_.OptionsWithClients());
  CertificateAuthority& authority = folder_.authority();
  const auto north = *Connect(server.tcp(), folder_.Client("a", authority.IssueClient("north")));
  const auto again = *Connect(server.tcp(), folder_.Client("b", authority.IssueClient("north")));
  const auto south = *Connect(server.tcp(), folder_.Client("c", authority.IssueClient("south")));
  const auto rig =
      *Connect(server.tcp(), folder_.Client("d", authority.IssueClient("", "spiffe://rigs/1")));
  const auto local = server.Connect();
  const auto session = north->CreateSession(CageRequest());
  ASSERT_TRUE(session.ok()) << session.status();
  EXPECT_TRUE(again->GetSession(session->session_id()).ok());
  for (FitClient* other : {south.get(), rig.get(), local.get()}) {
    EXPECT_EQ(ReasonOf(other->GetSession(session->session_id()).status()), "NO_SESSION");
    EXPECT_THAT(*other->ListSessions(), IsEmpty());
  }
  const auto of_rig = rig->CreateSession(CageRequest());
  ASSERT_TRUE(of_rig.ok()) << of_rig.status();
  EXPECT_EQ(rig->ListSessions()->size(), 1u);
  EXPECT_EQ(south->ListSessions()->size(), 0u);
}

TEST_F(TlsTest, ACertificateWithoutANameIsNobodys) {
  const RunningServer server(folder_.OptionsWithClients());
  const auto client =
      Connect(server.tcp(), folder_.Client("a", folder_.authority().IssueClient("")));
  ASSERT_TRUE(client.ok()) << client.status();
  const absl::Status status = (*client)->ListSessions().status();
  EXPECT_TRUE(absl::IsUnauthenticated(status)) << status;
  EXPECT_EQ(ReasonOf(status), "NO_VALID_CREDENTIALS");
}

TEST_F(TlsTest, WithTokensACertificateIsNotEnough) {
  ServerOptions options = folder_.OptionsWithClients();
  options.tokens = folder_.Write("tokens", "");
  const RunningServer server(options);
  const auto client =
      Connect(server.tcp(), folder_.Client("a", folder_.authority().IssueClient("north")));
  ASSERT_TRUE(client.ok()) << client.status();
  EXPECT_TRUE(absl::IsUnauthenticated((*client)->ListSessions().status()));
}

// ---- Files that cannot be used ----

TEST_F(TlsTest, FilesThatCannotBeUsedAreErrorsAtTheStart) {
  const std::string& other_key = folder_.Write("other.key", folder_.authority().Issue("x").key);
  ServerOptions missing = folder_.Options(), mismatch = missing, no_roots = missing;
  missing.tls_cert = "/nowhere/cert.pem";
  mismatch.tls_key = other_key;
  no_roots.tls_client_ca = folder_.Write("empty.pem", "");
  const std::vector<std::pair<ServerOptions, std::string>> bad = {
      {missing, "/nowhere/cert.pem: cannot be read: No such file"},
      {mismatch, other_key + ": is not the key of the certificate in " + mismatch.tls_cert},
      {no_roots, no_roots.tls_client_ca + ": holds no certificate"}};
  for (const auto& [options, what] : bad) {
    const absl::Status status = Server::Start(options, SilentLog()).status();
    EXPECT_THAT(std::string(status.message()), HasSubstr(what));
  }
}

}  // namespace
}  // namespace cagefit::server
