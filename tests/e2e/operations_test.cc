// What whoever operates a server does to it: probes, scrapes, signals.
#include <gmock/gmock.h>
#include <grpcpp/grpcpp.h>
#include <signal.h>

#include <atomic>
#include <nlohmann/json.hpp>
#include <thread>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "client/fit_client.h"
#include "client/mesh_from_proto.h"
#include "tests/e2e/program.h"
#include "tests/support/frames.h"

namespace cagefit::testing {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

// The address in the next line of a server's output, which must begin with `what`.
std::string NextAddress(ServerProgram* server, const std::string& what) {
  const std::string line = server->program().ReadLine();
  EXPECT_THAT(line, StartsWith(what));
  return line.substr(line.rfind(' ') + 1);
}

ProgramResult Health(const std::string& address, const std::string& service = "cagefit.v1.Fitting",
                     const std::vector<std::string>& more = {}) {
  std::vector<std::string> arguments = {"health", "--server", address, "--service", service};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return RunCagefit(arguments);
}

TEST(OperationsTest, HealthIsOneWordAndAnExitCode) {
  ServerProgram server({"--health-listen", "127.0.0.1:0", "--drain-delay", "30"});
  const std::string health = NextAddress(&server, "health on ");
  for (const std::string& address : {server.address(), health}) {
    EXPECT_EQ(Health(address).out, "serving\n");
    EXPECT_EQ(Health(address).exit_code, 0);
  }
  EXPECT_EQ(Health(health, "nothing").out, "unknown-service\n");
  EXPECT_EQ(Health(health, "nothing").exit_code, 1);
  const auto json = nlohmann::json::parse(Health(health, "", {"--json"}).out);
  EXPECT_EQ(json["health"], "serving");
  EXPECT_EQ(json["server"], health);

  server.program().Signal(SIGTERM);
  ProgramResult result;
  do {
    result = Health(health);
  } while (result.exit_code == 0);  // the signal is on its way
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_EQ(result.out, "not-serving\n");
  EXPECT_EQ(Health(health, "").out, "serving\n");  // alive
  EXPECT_EQ(RunCagefit({"session", "list", "--server", server.address()}).exit_code, 0);
  server.program().Signal(SIGTERM);  // no patience for the delay
  EXPECT_EQ(server.program().Wait(), 1);
  const ProgramResult none = Health(health, "", {"--timeout", "0.5"});
  EXPECT_EQ(none.out, "no-server\n");
  EXPECT_EQ(none.exit_code, 3);
}

// A client that keeps a stream busy until the server ends it.
struct BusyStream {
  std::unique_ptr<client::FitClient> client;
  std::unique_ptr<client::FrameStream> stream;
  std::thread sender, receiver;
  std::atomic<int> sent{0}, answered{0};
  absl::Status end;

  void Begin(const std::string& address) {
    client = client::FitClient::Connect({address}).value();
    v1::CreateSessionRequest request;
    *request.mutable_control_mesh() = client::ToProto(FrameCage(1));
    stream = client->OpenStream(client->CreateSession(request)->session_id()).value();
    sender = std::thread([this] {
      client::OutgoingFrame frame;
      frame.draco = FrameBytes(MovingCloud(0));
      for (; stream->Send(frame).ok(); ++frame.sequence_number) ++sent;
    });
    receiver = std::thread([this] {
      for (;;) {
        const auto frame = stream->Receive();
        if (!frame.ok() || !frame->has_value()) {
          end = frame.status();
          return;
        }
        EXPECT_EQ((*frame)->status, absl::OkStatus());
        ++answered;
      }
    });
  }
};

TEST(OperationsTest, EndsWithinTheDrainAndASecondUnder20LiveStreams) {
  constexpr double kDrainSeconds = 10;
  ServerProgram server({"--drain-seconds", absl::StrCat(kDrainSeconds)});
  std::vector<BusyStream> streams(20);
  for (BusyStream& stream : streams) stream.Begin(server.address());
  for (BusyStream& stream : streams) {
    while (stream.answered < 1) absl::SleepFor(absl::Milliseconds(5));
  }
  const absl::Time start = absl::Now();
  server.program().Signal(SIGTERM);
  EXPECT_EQ(server.program().Wait(), 0);
  const absl::Duration took = absl::Now() - start;
  EXPECT_LT(took, absl::Seconds(kDrainSeconds + 1));
  std::cout << "ended after " << took << "\n";
  for (BusyStream& stream : streams) {
    stream.sender.join();
    stream.receiver.join();
    EXPECT_TRUE(absl::IsUnavailable(stream.end)) << stream.end;
    // Of what was sent, all that the server had read, and it reads few ahead.
    EXPECT_GE(stream.answered, stream.sent - 4);
  }
}

TEST(OperationsTest, EndsAtTheDrainsEndAlthoughAClientHangsOn) {
  constexpr double kDrainSeconds = 1;
  ServerProgram server({"--drain-seconds", absl::StrCat(kDrainSeconds)});
  const auto client = client::FitClient::Connect({server.address()}).value();
  v1::CreateSessionRequest request;
  *request.mutable_control_mesh() = client::ToProto(FrameCage(5));
  const auto stream = client->OpenStream(client->CreateSession(request)->session_id()).value();
  // A fit that takes longer than the drain.
  client::OutgoingFrame frame;
  frame.draco = FrameBytes(MovingCloud(0, 500'000));
  ASSERT_EQ(stream->Send(frame), absl::OkStatus());
  absl::SleepFor(absl::Milliseconds(300));
  const absl::Time start = absl::Now();
  server.program().Signal(SIGTERM);
  server.program().Wait();
  EXPECT_LT(absl::Now() - start, absl::Seconds(kDrainSeconds + 1));
}

TEST(OperationsTest, ASecondSignalEndsAtOnce) {
  ServerProgram server({"--drain-delay", "60"});
  server.program().Signal(SIGTERM);
  server.program().Signal(SIGINT);
  const absl::Time start = absl::Now();
  EXPECT_EQ(server.program().Wait(), 1);
  EXPECT_LT(absl::Now() - start, absl::Seconds(5));
}

}  // namespace
}  // namespace cagefit::testing
