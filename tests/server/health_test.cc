// What probes and load balancers see of a running server.
#include <gmock/gmock.h>
#include <grpcpp/generic/generic_stub.h>
#include <grpcpp/grpcpp.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <future>
#include <thread>
#include <vector>

#include "absl/time/clock.h"
#include "cagefit/v1/fitting.grpc.pb.h"
#include "grpc/health/v1/health.grpc.pb.h"
#include "tests/server/running_server.h"

namespace cagefit::server {
namespace {

using cagefit::testing::FrameBytes;
using cagefit::testing::MovingCloud;
using grpc::health::v1::Health;
using grpc::health::v1::HealthCheckRequest;
using grpc::health::v1::HealthCheckResponse;
using testing::CageRequest;
using testing::FitMovingFrames;
using testing::ReceiveFrame;
using testing::RunningServer;

constexpr char kFitting[] = "cagefit.v1.Fitting";

std::shared_ptr<grpc::Channel> ChannelTo(const std::string& address) {
  return grpc::CreateChannel(address, grpc::InsecureChannelCredentials());
}

bool IsServing(Health::Stub* stub, const std::string& service) {
  grpc::ClientContext context;
  context.set_deadline(std::chrono::system_clock::now() + std::chrono::seconds(30));
  HealthCheckRequest request;
  HealthCheckResponse response;
  request.set_service(service);
  const grpc::Status status = stub->Check(&context, request, &response);
  EXPECT_TRUE(status.ok()) << status.error_message();
  return response.status() == HealthCheckResponse::SERVING;
}

ServerOptions WithHealthPort() {
  ServerOptions options;
  options.health_listen = "127.0.0.1:0";
  return options;
}

TEST(HealthTest, BothPortsSayThatAServerIsAliveAndReady) {
  RunningServer server(WithHealthPort());
  ASSERT_EQ(server->health_addresses().size(), 1u);
  for (const std::string& address : {server.tcp(), server->health_addresses()[0]}) {
    const auto stub = Health::NewStub(ChannelTo(address));
    EXPECT_TRUE(IsServing(stub.get(), "")) << address;
    EXPECT_TRUE(IsServing(stub.get(), kFitting)) << address;
  }
}

TEST(HealthTest, TheHealthPortServesNothingElse) {
  RunningServer server(WithHealthPort());
  const auto fitting = v1::Fitting::NewStub(ChannelTo(server->health_addresses()[0]));
  grpc::ClientContext context;
  v1::ListSessionsResponse sessions;
  EXPECT_EQ(fitting->ListSessions(&context, {}, &sessions).error_code(),
            grpc::StatusCode::UNIMPLEMENTED);

  grpc::GenericStub any(ChannelTo(server->health_addresses()[0]));
  grpc::ClientContext reflection;
  grpc::Slice nothing;
  grpc::ByteBuffer empty(&nothing, 1), response;
  std::promise<grpc::StatusCode> code;
  any.UnaryCall(&reflection, "/grpc.reflection.v1alpha.ServerReflection/ServerReflectionInfo",
                grpc::StubOptions(), &empty, &response,
                [&code](const grpc::Status& status) { code.set_value(status.error_code()); });
  EXPECT_EQ(code.get_future().get(), grpc::StatusCode::UNIMPLEMENTED);
}

TEST(HealthTest, AHealthPortThatIsTakenIsNamed) {
  RunningServer server;
  ServerOptions options;
  options.listen = {"127.0.0.1:0"};
  options.health_listen = server.tcp();
  const auto second = Server::Start(options, SilentLog());
  EXPECT_TRUE(absl::IsUnavailable(second.status())) << second.status();
  EXPECT_THAT(std::string(second.status().message()), ::testing::HasSubstr(server.tcp()));
}

TEST(HealthTest, AServerThatIsAboutToDrainIsNotReadyAndStillWorks) {
  RunningServer server(WithHealthPort());
  const auto client = server.Connect();
  const auto session = client->CreateSession(CageRequest());
  server->StopBeingReady();
  for (const std::string& address : {server.tcp(), server->health_addresses()[0]}) {
    const auto stub = Health::NewStub(ChannelTo(address));
    EXPECT_FALSE(IsServing(stub.get(), kFitting)) << address;
    EXPECT_TRUE(IsServing(stub.get(), "")) << address;
  }
  const auto stream = client->OpenStream(session->session_id());
  ASSERT_TRUE(stream.ok()) << stream.status();
  EXPECT_EQ(FitMovingFrames(stream->get(), 0, 2).back().status, absl::OkStatus());
}

TEST(HealthTest, AWatchDoesNotHoldUpShutdown) {
  RunningServer server(WithHealthPort());
  grpc::ClientContext contexts[2];
  std::vector<std::unique_ptr<grpc::ClientReader<HealthCheckResponse>>> watches;
  HealthCheckRequest request;
  request.set_service(kFitting);
  for (const std::string& address : {server.tcp(), server->health_addresses()[0]}) {
    const auto stub = Health::NewStub(ChannelTo(address));
    watches.push_back(stub->Watch(&contexts[watches.size()], request));
    HealthCheckResponse response;
    ASSERT_TRUE(watches.back()->Read(&response));
    EXPECT_EQ(response.status(), HealthCheckResponse::SERVING);
  }
  const absl::Time start = absl::Now();
  server->Shutdown(absl::Seconds(60));
  EXPECT_LT(absl::Now() - start, absl::Seconds(30));
  HealthCheckResponse response;
  for (const auto& watch : watches) {
    ASSERT_TRUE(watch->Read(&response));
    EXPECT_EQ(response.status(), HealthCheckResponse::NOT_SERVING);
  }
}

// Asks until `stop`, a hundred times at least, and returns the 99th percentile.
absl::Duration SlowAnswer(const std::string& address, const std::atomic<bool>& stop) {
  const auto stub = Health::NewStub(ChannelTo(address));
  std::vector<absl::Duration> waited;
  while (!stop || waited.size() < 100) {
    const absl::Time start = absl::Now();
    EXPECT_TRUE(IsServing(stub.get(), kFitting));
    waited.push_back(absl::Now() - start);
    absl::SleepFor(absl::Milliseconds(5));  // as a probe does: with pauses
  }
  std::sort(waited.begin(), waited.end());
  std::cout << address << ": " << waited.size() << " answers, median " << waited[waited.size() / 2]
            << ", 99th percentile " << waited[waited.size() * 99 / 100] << ", slowest "
            << waited.back() << "\n";
  return waited[waited.size() * 99 / 100];
}

// Fits frames of 50,000 points, one after another, until `stop`.
void KeepFitting(const RunningServer& server, const std::atomic<bool>& stop) {
  const auto client = server.Connect();
  const auto session = client->CreateSession(CageRequest(3));
  const auto stream = client->OpenStream(session->session_id());
  client::OutgoingFrame frame;
  frame.draco = FrameBytes(MovingCloud(0, 50'000));
  for (; !stop; ++frame.sequence_number) {
    ASSERT_EQ((*stream)->Send(frame), absl::OkStatus());
    ASSERT_EQ(ReceiveFrame(stream->get()).status, absl::OkStatus());
  }
}

TEST(HealthTest, AnswersWithin50MillisecondsWhileEveryWorkerSolves) {
  RunningServer server(WithHealthPort());
  std::atomic<bool> stop{false};
  std::vector<std::thread> sessions;
  for (int k = 0; k < 4; ++k) {
    sessions.emplace_back([&] { KeepFitting(server, stop); });
  }
  absl::Duration plain;
  std::thread probe([&] { plain = SlowAnswer(server->health_addresses()[0], stop); });
  std::thread timer([&stop] {
    absl::SleepFor(absl::Seconds(3));
    stop = true;
  });
  const absl::Duration main = SlowAnswer(server.tcp(), stop);
  for (std::thread* thread : {&probe, &timer}) thread->join();
  for (std::thread& session : sessions) session.join();
  EXPECT_LT(main, absl::Milliseconds(50));
  EXPECT_LT(plain, absl::Milliseconds(50));
}

}  // namespace
}  // namespace cagefit::server
