#include "server/transport/evaluate_loss_call.h"

#include <gtest/gtest.h>

#include <future>

#include "tests/server/transport/service_fixture.h"

namespace cagefit::server {
namespace {

using cagefit::testing::FrameBytes;
using cagefit::testing::FrameCage;
using cagefit::testing::MovingCloud;
using testing::BoundedContext;
using testing::ServiceLimits;
using testing::TestService;

v1::EvaluateLossRequest Request(const std::string& session_id) {
  v1::EvaluateLossRequest request;
  request.set_session_id(session_id);
  const Points3d V = FrameCage().vertices();
  request.mutable_vertices()->Add(V.data(), V.data() + V.size());
  request.mutable_frame()->set_data(FrameBytes(MovingCloud(0)));
  return request;
}

class EvaluateLossCallTest : public ::testing::Test {
 protected:
  grpc::Status Send(TestService* service, const std::string& blob, size_t chunk_bytes = 1 << 20) {
    BoundedContext context;
    const auto stream = service->stub->EvaluateLoss(&context);
    v1::DataChunk chunk;
    chunk.set_total_bytes(blob.size());
    for (size_t sent = 0; sent < blob.size(); sent += chunk_bytes) {
      chunk.set_data(blob.substr(sent, chunk_bytes));
      if (!stream->Write(chunk)) break;
    }
    stream->WritesDone();
    std::string bytes;
    while (stream->Read(&chunk)) bytes += chunk.data();
    const grpc::Status status = stream->Finish();
    detail_ = testing::DetailOf(context);
    EXPECT_TRUE(reply_.ParseFromString(bytes));
    return status;
  }
  grpc::Status Send(TestService* service, const v1::EvaluateLossRequest& request) {
    return Send(service, request.SerializeAsString());
  }

  v1::EvaluateLossReply reply_;
  v1::ErrorDetail detail_;
};

TEST_F(EvaluateLossCallTest, AnswersWhatTheSessionSays) {
  TestService service;
  const std::string id = service.CreateSession();
  const grpc::Status status = Send(&service, Request(id).SerializeAsString(), 100);
  ASSERT_TRUE(status.ok()) << status.error_message();
  testing::OpenSession alone(testing::CageConfig());
  const Frame frame = testing::MovingFrame(0);
  const auto loss = alone.session.EvaluateLoss(FrameCage().vertices(), &frame, nullptr);
  ASSERT_TRUE(loss.ok()) << loss.status();
  EXPECT_EQ(reply_.total(), loss->energies.total());
  ASSERT_EQ(reply_.gradient_size(), loss->gradient.size());
  for (int k = 0; k < reply_.gradient_size(); ++k) {
    EXPECT_EQ(reply_.gradient(k), loss->gradient.data()[k]);
  }
  service.WaitForFits(id);
}

TEST_F(EvaluateLossCallTest, ErrorsNameTheFieldsOfTheRequest) {
  TestService service;
  const std::string id = service.CreateSession();
  EXPECT_EQ(Send(&service, Request("nobody")).error_code(), grpc::StatusCode::NOT_FOUND);
  v1::EvaluateLossRequest request = Request(id);
  request.clear_frame();
  EXPECT_EQ(Send(&service, request).error_code(), grpc::StatusCode::FAILED_PRECONDITION);
  EXPECT_EQ(detail_.reason(), "NO_FRAME_YET");
  request = Request(id);
  request.mutable_frame()->set_data("no Draco");
  EXPECT_EQ(Send(&service, request).error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_EQ(detail_.field(), "frame.data");
  request = Request(id);
  request.mutable_frame()->set_point_count(499);
  EXPECT_EQ(Send(&service, request).error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_EQ(detail_.field(), "frame.point_count");
  request = Request(id);
  request.mutable_vertices()->Truncate(123);
  EXPECT_EQ(Send(&service, request).error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_EQ(detail_.field(), "vertices");
  EXPECT_EQ(Send(&service, std::string("\xff\xff\xff")).error_code(),
            grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_EQ(detail_.field(), "data");
  EXPECT_EQ(Send(&service, std::string()).error_code(), grpc::StatusCode::INVALID_ARGUMENT);
}

TEST_F(EvaluateLossCallTest, LimitsAreThoseOfFrames) {
  ServiceLimits limits;
  limits.store.session.max_frame_bytes = 1000;
  limits.store.session.max_control_vertices = 42;
  TestService service(limits);
  EXPECT_EQ(Send(&service, Request(service.CreateSession())).error_code(),
            grpc::StatusCode::RESOURCE_EXHAUSTED);
  EXPECT_EQ(detail_.field(), "frame.data");
  EXPECT_EQ(Send(&service, std::string(1 << 20, 'x')).error_code(),
            grpc::StatusCode::RESOURCE_EXHAUSTED);
  EXPECT_EQ(detail_.field(), "total_bytes");

  ServiceLimits poor;
  poor.budget_bytes = 100;
  TestService without_budget(poor);
  EXPECT_EQ(Send(&without_budget, Request("any")).error_code(),
            grpc::StatusCode::RESOURCE_EXHAUSTED);
  ServiceLimits busy;
  busy.scheduler.max_queued = 0;
  TestService without_room(busy);
  EXPECT_EQ(Send(&without_room, Request("any")).error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
}

TEST_F(EvaluateLossCallTest, DrainingAnswersNoMore) {
  TestService service;
  const std::string id = service.CreateSession();
  service.streams.DrainAll();
  EXPECT_EQ(Send(&service, Request(id)).error_code(), grpc::StatusCode::UNAVAILABLE);
  EXPECT_EQ(detail_.reason(), "DRAINING");
}

TEST_F(EvaluateLossCallTest, TakesItsTurnAndIsDroppedWhenItsCallerLeaves) {
  TestService service;
  const std::string id = service.CreateSession();
  std::promise<void> go;
  std::shared_future<void> gone = go.get_future();
  ASSERT_TRUE(service.scheduler.fits.Run(id, [gone] { gone.wait(); }).ok());
  BoundedContext context;
  const auto stream = service.stub->EvaluateLoss(&context);
  const std::string blob = Request(id).SerializeAsString();
  v1::DataChunk chunk;
  chunk.set_total_bytes(blob.size());
  chunk.set_data(blob);
  stream->Write(chunk);
  stream->WritesDone();
  context.TryCancel();
  EXPECT_EQ(stream->Finish().error_code(), grpc::StatusCode::CANCELLED);
  go.set_value();
  service.WaitForFits(id);
  // The session is free again.
  EXPECT_TRUE(Send(&service, Request(id)).ok());
}

}  // namespace
}  // namespace cagefit::server
