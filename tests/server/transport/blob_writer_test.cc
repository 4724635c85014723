#include "server/transport/blob_writer.h"

#include <gtest/gtest.h>

#include "server/transport/session_convert.h"
#include "tests/server/transport/service_fixture.h"

namespace cagefit::server {
namespace {

using testing::BoundedContext;
using testing::ServiceLimits;
using testing::TestService;

TEST(BlobWriterTest, SendsChunksOfAtMostAMebibyteThatTellTheTotal) {
  TestService service;
  SessionConfig config;
  config.control_mesh = cagefit::testing::FrameCage(6);
  const auto ledger = *service.store.Create(Principal(), config, absl::UnixEpoch());
  const std::string whole = ToProto(*config.control_mesh).SerializeAsString();
  ASSERT_GT(whole.size(), 1u << 20);

  BoundedContext context;
  v1::GetControlMeshRequest request;
  request.set_session_id(ledger->id());
  const auto reader = service.stub->GetControlMesh(&context, request);
  std::string blob;
  v1::DataChunk chunk;
  while (reader->Read(&chunk)) {
    EXPECT_EQ(chunk.total_bytes(), whole.size());
    EXPECT_LE(chunk.data().size(), 1u << 20);
    blob += chunk.data();
  }
  EXPECT_TRUE(reader->Finish().ok());
  EXPECT_TRUE(blob == whole);
}

TEST(BlobWriterTest, AnErrorEndsTheCallWithItsDetail) {
  TestService service;
  BoundedContext context;
  v1::GetControlMeshRequest request;
  request.set_session_id(service.CreateSession());
  request.set_sequence_number(5);
  const auto reader = service.stub->GetControlMesh(&context, request);
  v1::DataChunk chunk;
  EXPECT_FALSE(reader->Read(&chunk));
  EXPECT_EQ(reader->Finish().error_code(), grpc::StatusCode::NOT_FOUND);
  EXPECT_EQ(testing::DetailOf(context).reason(), "FRAME_NOT_FITTED");
}

TEST(BlobWriterTest, AFullQueueIsExhaustion) {
  ServiceLimits limits;
  limits.scheduler.max_queued = 0;
  TestService service(limits);
  BoundedContext context;
  v1::GetControlMeshRequest request;
  request.set_session_id(service.CreateSession());
  EXPECT_EQ(service.stub->GetControlMesh(&context, request)->Finish().error_code(),
            grpc::StatusCode::RESOURCE_EXHAUSTED);
}

TEST(BlobWriterTest, AReaderThatLeavesDoesNotHoldTheServer) {
  TestService service;
  SessionConfig config;
  config.control_mesh = cagefit::testing::FrameCage(6);
  const auto ledger = *service.store.Create(Principal(), config, absl::UnixEpoch());
  BoundedContext context;
  v1::GetControlMeshRequest request;
  request.set_session_id(ledger->id());
  const auto reader = service.stub->GetControlMesh(&context, request);
  v1::DataChunk chunk;
  ASSERT_TRUE(reader->Read(&chunk));
  context.TryCancel();
  EXPECT_EQ(reader->Finish().error_code(), grpc::StatusCode::CANCELLED);
}

}  // namespace
}  // namespace cagefit::server
