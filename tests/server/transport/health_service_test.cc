#include "server/transport/health_service.h"

#include <gmock/gmock.h>
#include <grpcpp/grpcpp.h>
#include <gtest/gtest.h>

#include <future>
#include <thread>

#include "core/base/private_folder.h"
#include "tests/server/transport/service_fixture.h"

namespace cagefit::server {
namespace {

using grpc::health::v1::Health;
using grpc::health::v1::HealthCheckRequest;
using grpc::health::v1::HealthCheckResponse;
using testing::BoundedContext;

constexpr char kFitting[] = "cagefit.v1.Fitting";

class HealthServiceTest : public ::testing::Test {
 protected:
  HealthServiceTest() {
    grpc::ServerBuilder builder;
    const std::string address = "unix:" + folder_.path() + "/socket";
    builder.AddListeningPort(address, grpc::InsecureServerCredentials());
    builder.RegisterService(&service_);
    network_ = builder.BuildAndStart();
    stub_ = Health::NewStub(grpc::CreateChannel(address, grpc::InsecureChannelCredentials()));
  }
  ~HealthServiceTest() override { network_->Shutdown(std::chrono::system_clock::now()); }

  static HealthCheckRequest Of(const std::string& service) {
    HealthCheckRequest request;
    request.set_service(service);
    return request;
  }
  HealthCheckResponse::ServingStatus Check(const std::string& service) {
    BoundedContext context;
    HealthCheckResponse response;
    const grpc::Status status = stub_->Check(&context, Of(service), &response);
    EXPECT_TRUE(status.ok()) << status.error_message();
    return response.status();
  }

  PrivateFolder folder_ = PrivateFolder::Create().value();
  Readiness readiness_;
  HealthService service_{&readiness_};
  std::unique_ptr<grpc::Server> network_;
  std::unique_ptr<Health::Stub> stub_;
};

TEST_F(HealthServiceTest, FittingIsAsReadyAsTheServerAndTheProcessIsAliveAllTheSame) {
  EXPECT_EQ(Check(kFitting), HealthCheckResponse::SERVING);
  EXPECT_EQ(Check(""), HealthCheckResponse::SERVING);
  readiness_.Set("store");
  EXPECT_EQ(Check(kFitting), HealthCheckResponse::NOT_SERVING);
  EXPECT_EQ(Check(""), HealthCheckResponse::SERVING);
  readiness_.Clear("store");
  EXPECT_EQ(Check(kFitting), HealthCheckResponse::SERVING);
}

TEST_F(HealthServiceTest, AnUnknownServiceIsNotFound) {
  BoundedContext context;
  HealthCheckResponse response;
  EXPECT_EQ(stub_->Check(&context, Of("cagefit"), &response).error_code(),
            grpc::StatusCode::NOT_FOUND);
}

TEST_F(HealthServiceTest, AWatchTellsEveryLastingChange) {
  BoundedContext context;
  const auto watch = stub_->Watch(&context, Of(kFitting));
  HealthCheckResponse response;
  ASSERT_TRUE(watch->Read(&response));
  EXPECT_EQ(response.status(), HealthCheckResponse::SERVING);
  readiness_.Set("store");
  ASSERT_TRUE(watch->Read(&response));
  EXPECT_EQ(response.status(), HealthCheckResponse::NOT_SERVING);
  readiness_.Clear("store");
  ASSERT_TRUE(watch->Read(&response));
  EXPECT_EQ(response.status(), HealthCheckResponse::SERVING);
}

TEST_F(HealthServiceTest, AWatchOfAnUnknownServiceSaysSo) {
  BoundedContext context;
  const auto watch = stub_->Watch(&context, Of("cagefit"));
  HealthCheckResponse response;
  ASSERT_TRUE(watch->Read(&response));
  EXPECT_EQ(response.status(), HealthCheckResponse::SERVICE_UNKNOWN);
}

TEST_F(HealthServiceTest, WatchesTellWhatIsNewAndEnd) {
  BoundedContext context;
  const auto watch = stub_->Watch(&context, Of(kFitting));
  HealthCheckResponse response;
  ASSERT_TRUE(watch->Read(&response));
  readiness_.Set("draining");
  service_.EndWatches();
  ASSERT_TRUE(watch->Read(&response));
  EXPECT_EQ(response.status(), HealthCheckResponse::NOT_SERVING);
  EXPECT_FALSE(watch->Read(&response));
  EXPECT_EQ(watch->Finish().error_code(), grpc::StatusCode::UNAVAILABLE);

  BoundedContext later;
  const auto late = stub_->Watch(&later, Of(""));
  ASSERT_TRUE(late->Read(&response));
  EXPECT_EQ(response.status(), HealthCheckResponse::SERVING);
  EXPECT_FALSE(late->Read(&response));
  EXPECT_EQ(late->Finish().error_code(), grpc::StatusCode::UNAVAILABLE);
}

TEST_F(HealthServiceTest, AWatchThatIsCancelledMakesRoomForAnother) {
  std::vector<std::unique_ptr<BoundedContext>> contexts;
  std::vector<std::unique_ptr<grpc::ClientReader<HealthCheckResponse>>> watches;
  HealthCheckResponse response;
  for (size_t k = 0; k < HealthService::kMaxWatches; ++k) {
    contexts.push_back(std::make_unique<BoundedContext>());
    watches.push_back(stub_->Watch(contexts.back().get(), Of("")));
    ASSERT_TRUE(watches.back()->Read(&response));
  }
  const auto watch_one_more = [this] {
    BoundedContext context;
    HealthCheckResponse answer;
    const auto watch = stub_->Watch(&context, Of(kFitting));
    if (watch->Read(&answer)) context.TryCancel();
    while (watch->Read(&answer)) {
    }
    return watch->Finish().error_code();
  };
  EXPECT_EQ(watch_one_more(), grpc::StatusCode::RESOURCE_EXHAUSTED);
  contexts[0]->TryCancel();
  while (watches[0]->Read(&response)) {
  }
  grpc::StatusCode code = grpc::StatusCode::RESOURCE_EXHAUSTED;
  while (code == grpc::StatusCode::RESOURCE_EXHAUSTED)
    code = watch_one_more();  // the server's turn
  EXPECT_EQ(code, grpc::StatusCode::CANCELLED);
}

TEST_F(HealthServiceTest, ReadinessMayChangeWhileWatchesComeAndGo) {
  std::atomic<bool> stop{false};
  std::thread changes([&] {
    while (!stop) {
      readiness_.Set("store");
      readiness_.Clear("store");
    }
  });
  HealthCheckResponse response;
  for (int k = 0; k < 50; ++k) {
    BoundedContext context;
    const auto watch = stub_->Watch(&context, Of(kFitting));
    for (int read = 0; read < 5; ++read) {
      const auto before = response.status();
      ASSERT_TRUE(watch->Read(&response));
      if (read == 0) continue;
      ASSERT_NE(response.status(), before);  // changes only
    }
  }
  stop = true;
  changes.join();
}

}  // namespace
}  // namespace cagefit::server
