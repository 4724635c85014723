// Every method of the service against every kind of credentials.
#include <gmock/gmock.h>
#include <google/protobuf/descriptor.h>
#include <gtest/gtest.h>

#include <fstream>
#include <functional>
#include <map>

#include "absl/strings/escaping.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "server/session/digest.h"
#include "tests/server/log_lines.h"
#include "tests/server/raw_call.h"
#include "tests/server/running_server.h"

namespace cagefit::server {
namespace {

using testing::CageRequest;
using testing::CallRaw;
using ::testing::HasSubstr;
using ::testing::Not;
using testing::RawAnswer;
using testing::RunningServer;

using Metadata = std::vector<std::pair<std::string, std::string>>;

constexpr char kUnknownId[] = "0123456789abcdef0123456789abcdef";

Metadata Bearer(const std::string& token) { return {{"authorization", "Bearer " + token}}; }

std::string Line(const std::string& name, const std::string& token, const std::string& rest = "") {
  const Digest digest = Sha256(token);
  return absl::StrCat(name, " ",
                      absl::BytesToHexString(absl::string_view(
                          reinterpret_cast<const char*>(digest.data()), digest.size())),
                      " ", rest, "\n");
}

template <typename Request>
std::string WithId(const std::string& session_id) {
  Request request;
  request.set_session_id(session_id);
  return request.SerializeAsString();
}

template <typename Chunk>
std::string InAChunk(const std::string& bytes) {
  Chunk chunk;
  chunk.set_total_bytes(bytes.size());
  chunk.set_data(bytes);
  return chunk.SerializeAsString();
}

std::string Loss(const std::string& session_id) {
  v1::EvaluateLossRequest request;
  request.set_session_id(session_id);
  for (int k = 0; k < 3 * 42; ++k) request.add_vertices(k);
  return InAChunk<v1::DataChunk>(request.SerializeAsString());
}

std::string Open(const std::string& session_id) {
  v1::FitFramesRequest request;
  request.mutable_open()->set_session_id(session_id);
  return request.SerializeAsString();
}

// How a method is called, and what it answers its session's owner.
struct MethodCase {
  std::function<std::string(const std::string& session_id)> request;
  bool names_a_session = true;
  grpc::StatusCode code = grpc::StatusCode::OK;
  std::string reason = {};
};

// A new method without a line here fails the test.
const std::map<std::string, MethodCase>& Cases() {
  static const auto* const cases = new std::map<std::string, MethodCase>{
      {"CreateSession",
       {[](const std::string&) { return CageRequest().SerializeAsString(); }, false}},
      {"CreateSessionFromStream",
       {[](const std::string&) {
          return InAChunk<v1::CreateSessionChunk>(CageRequest().SerializeAsString());
        },
        false}},
      {"GetSession", {WithId<v1::GetSessionRequest>}},
      {"ListSessions", {[](const std::string&) { return std::string(); }, false}},
      {"DeleteSession", {WithId<v1::DeleteSessionRequest>}},
      {"GetControlMesh", {WithId<v1::GetControlMeshRequest>}},
      {"GetSurface", {WithId<v1::GetSurfaceRequest>}},
      {"GetReplies", {WithId<v1::GetRepliesRequest>}},
      {"GetStencils", {WithId<v1::GetStencilsRequest>}},
      {"EvaluateLoss", {Loss, true, grpc::StatusCode::FAILED_PRECONDITION, "NO_FRAME_YET"}},
      {"FitFrames", {Open}}};
  return *cases;
}

class CredentialsTest : public ::testing::Test {
 protected:
  CredentialsTest() {
    ServerOptions options;
    options.tokens = folder_.path() + "/tokens";
    std::ofstream(options.tokens) << Line("north", "good") << Line("south", "foreign")
                                  << Line("north", "expired", "expires=2020-01-01T00:00:00Z");
    server_ = std::make_unique<RunningServer>(options, log_.log());
    channel_ = grpc::CreateChannel(server_->tcp(), grpc::InsecureChannelCredentials());
  }

  RawAnswer Call(const std::string& method, const std::string& request, const Metadata& metadata) {
    return CallRaw(channel_, "/cagefit.v1.Fitting/" + method, request, metadata);
  }
  std::string NewSession(const std::string& token) {
    const RawAnswer answer =
        Call("CreateSession", CageRequest().SerializeAsString(), Bearer(token));
    v1::Session session;
    EXPECT_TRUE(answer.status.ok()) << answer.status.error_message();
    if (answer.status.ok()) session.ParseFromString(answer.messages.front());
    return session.session_id();
  }

  PrivateFolder folder_ = PrivateFolder::Create().value();
  testing::LogLines log_;
  std::unique_ptr<RunningServer> server_;
  std::shared_ptr<grpc::Channel> channel_;
};

TEST_F(CredentialsTest, EveryMethodHasACase) {
  const google::protobuf::ServiceDescriptor* service =
      v1::Session::descriptor()->file()->FindServiceByName("Fitting");
  ASSERT_NE(service, nullptr);
  for (int k = 0; k < service->method_count(); ++k) {
    EXPECT_EQ(Cases().count(service->method(k)->name()), 1u)
        << service->method(k)->name() << " has no line in the table of this test";
  }
  EXPECT_EQ(Cases().size(), static_cast<size_t>(service->method_count()));
}

TEST_F(CredentialsTest, NoMethodSaysWhatIsWrongWithCredentials) {
  const std::string id = NewSession("good");
  Metadata two = Bearer("good");
  two.push_back(two.front());
  const std::map<std::string, Metadata> wrong = {
      {"none", {}},
      {"bad", Bearer("bad")},
      {"expired", Bearer("expired")},
      {"longer", Bearer("good2")},
      {"shorter", Bearer("goo")},
      {"empty", {{"authorization", ""}}},
      {"no token", {{"authorization", "Bearer "}}},
      {"no scheme", {{"authorization", "good"}}},
      {"another scheme", {{"authorization", "Basic good"}}},
      {"the digest", Bearer(Line("", "good").substr(1, 64))},
      {"huge", Bearer(std::string(5000, 'x'))},
      {"two", two}};
  for (const auto& [method, method_case] : Cases()) {
    for (const auto& [name, metadata] : wrong) {
      const RawAnswer answer = Call(method, method_case.request(id), metadata);
      const std::string what = absl::StrCat(method, " with ", name);
      EXPECT_EQ(answer.status.error_code(), grpc::StatusCode::UNAUTHENTICATED) << what;
      EXPECT_EQ(answer.status.error_message(), "this server wants a valid token or certificate")
          << what;
      EXPECT_EQ(answer.detail.reason(), "NO_VALID_CREDENTIALS") << what;
      EXPECT_TRUE(answer.messages.empty()) << what;
    }
  }
  EXPECT_EQ(
      Call("GetSession", WithId<v1::GetSessionRequest>(id), Bearer("good")).status.error_code(),
      grpc::StatusCode::OK);
}

TEST_F(CredentialsTest, EveryMethodAnswersTheOwner) {
  for (const auto& [method, method_case] : Cases()) {
    const RawAnswer answer = Call(method, method_case.request(NewSession("good")), Bearer("good"));
    EXPECT_EQ(answer.status.error_code(), method_case.code)
        << method << ": " << answer.status.error_message();
    EXPECT_EQ(answer.detail.reason(), method_case.reason) << method;
  }
}

TEST_F(CredentialsTest, ToAnotherASessionIsAsOneThatDoesNotExist) {
  const std::string id = NewSession("good");
  for (const auto& [method, method_case] : Cases()) {
    if (!method_case.names_a_session) continue;
    const RawAnswer foreign = Call(method, method_case.request(id), Bearer("foreign"));
    const RawAnswer unknown = Call(method, method_case.request(kUnknownId), Bearer("foreign"));
    EXPECT_EQ(foreign.status.error_code(), grpc::StatusCode::NOT_FOUND) << method;
    EXPECT_EQ(foreign.detail.reason(), "NO_SESSION") << method;
    const auto as_unknown = [&id](const std::string& text) {
      return absl::StrReplaceAll(text, {{id, kUnknownId}});
    };
    EXPECT_EQ(as_unknown(foreign.status.error_message()), unknown.status.error_message()) << method;
    EXPECT_EQ(as_unknown(foreign.trailers), unknown.trailers) << method;
    EXPECT_TRUE(foreign.messages.empty()) << method;
  }
  // Nothing of it had an effect.
  v1::Session session;
  const RawAnswer own = Call("GetSession", WithId<v1::GetSessionRequest>(id), Bearer("good"));
  ASSERT_TRUE(own.status.ok()) << own.status.error_message();
  session.ParseFromString(own.messages.front());
  EXPECT_EQ(session.epoch(), 0u);
}

TEST_F(CredentialsTest, OnlyOwnSessionsAreListed) {
  const std::string id = NewSession("good");
  const std::string other = NewSession("foreign");
  v1::ListSessionsResponse response;
  response.ParseFromString(Call("ListSessions", "", Bearer("foreign")).messages.front());
  ASSERT_EQ(response.sessions_size(), 1);
  EXPECT_EQ(response.sessions(0).session_id(), other);
}

TEST_F(CredentialsTest, UnixSocketsWantATokenToo) {
  channel_ = grpc::CreateChannel(server_->unix_socket(), grpc::InsecureChannelCredentials());
  EXPECT_EQ(Call("ListSessions", "", {}).status.error_code(), grpc::StatusCode::UNAUTHENTICATED);
  EXPECT_TRUE(Call("ListSessions", "", Bearer("good")).status.ok());
}

TEST_F(CredentialsTest, HealthIsOpenToAll) {
  const RawAnswer answer = CallRaw(channel_, "/grpc.health.v1.Health/Check", "", {});
  EXPECT_TRUE(answer.status.ok()) << answer.status.error_message();
}

TEST_F(CredentialsTest, NoTokenGetsIntoTheLog) {
  const std::string id = NewSession("good");
  for (const auto& [method, method_case] : Cases()) {
    for (const char* token : {"good", "expired", "bad-token"}) {
      Call(method, method_case.request(id), Bearer(token));
    }
  }
  std::ofstream(folder_.path() + "/tokens") << "north not-a-digest\n";
  ASSERT_TRUE(log_.WaitFor("the old ones stay in force"));
  const std::string log = log_.All();
  EXPECT_THAT(log, HasSubstr("method=FitFrames"));
  for (const char* secret : {"Bearer", "bad-token", "not-a-digest"}) {
    EXPECT_THAT(log, Not(HasSubstr(secret)));
  }
  EXPECT_THAT(log, Not(HasSubstr(Line("", "good").substr(1, 64))));
}

TEST(ServerTokensTest, AFileThatCannotBeUsedIsAnErrorAtTheStart) {
  const PrivateFolder folder = PrivateFolder::Create().value();
  ServerOptions options;
  options.listen = {"127.0.0.1:0"};
  options.tokens = folder.path() + "/tokens";
  EXPECT_THAT(std::string(Server::Start(options, SilentLog()).status().message()),
              HasSubstr(options.tokens + ": cannot be read"));
  std::ofstream(options.tokens) << "# none\nnorth secret\n";
  const absl::Status status = Server::Start(options, SilentLog()).status();
  EXPECT_THAT(std::string(status.message()), HasSubstr(options.tokens + ":2: "));
  EXPECT_THAT(std::string(status.message()), Not(HasSubstr("secret")));
}

}  // namespace
}  // namespace cagefit::server
