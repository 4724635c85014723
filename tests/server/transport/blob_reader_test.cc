#include "server/transport/blob_reader.h"

#include <gtest/gtest.h>

#include "server/transport/session_convert.h"
#include "tests/server/transport/service_fixture.h"

namespace cagefit::server {
namespace {

using testing::BoundedContext;
using testing::ServiceLimits;
using testing::TestService;

std::string Request() {
  v1::CreateSessionRequest request;
  request.set_name("streamed");
  *request.mutable_control_mesh() = ToProto(cagefit::testing::FrameCage());
  return request.SerializeAsString();
}

v1::CreateSessionChunk Chunk(uint64_t total_bytes, const std::string& data) {
  v1::CreateSessionChunk chunk;
  chunk.set_total_bytes(total_bytes);
  chunk.set_data(data);
  return chunk;
}

class BlobReaderTest : public ::testing::Test {
 protected:
  grpc::Status Send(TestService* service, const std::vector<v1::CreateSessionChunk>& chunks) {
    BoundedContext context;
    const auto writer = service->stub->CreateSessionFromStream(&context, &session_);
    for (const auto& chunk : chunks) {
      if (!writer->Write(chunk)) break;
    }
    writer->WritesDone();
    const grpc::Status status = writer->Finish();
    detail_ = testing::DetailOf(context);
    return status;
  }
  void ExpectRefused(const std::vector<v1::CreateSessionChunk>& chunks, const std::string& field) {
    TestService service;
    const grpc::Status status = Send(&service, chunks);
    EXPECT_EQ(status.error_code(), grpc::StatusCode::INVALID_ARGUMENT) << status.error_message();
    EXPECT_EQ(detail_.field(), field) << status.error_message();
  }

  v1::Session session_;
  v1::ErrorDetail detail_;
};

TEST_F(BlobReaderTest, PutsTheRequestTogether) {
  TestService service;
  const std::string blob = Request();
  std::vector<v1::CreateSessionChunk> chunks;
  for (size_t k = 0; k < blob.size(); k += 100) {
    chunks.push_back(Chunk(blob.size(), blob.substr(k, 100)));
  }
  const grpc::Status status = Send(&service, chunks);
  EXPECT_TRUE(status.ok()) << status.error_message();
  EXPECT_EQ(session_.name(), "streamed");
  EXPECT_EQ(session_.control_vertices(), 42u);
  EXPECT_TRUE(service.store.Find(session_.session_id()).ok());
}

TEST_F(BlobReaderTest, RefusesATotalThatIsNotMet) {
  const std::string blob = Request();
  ExpectRefused({Chunk(blob.size() + 1, blob)}, "data");
  ExpectRefused({Chunk(blob.size() - 1, blob)}, "data");
  ExpectRefused({}, "data");
}

TEST_F(BlobReaderTest, RefusesATotalThatChanges) {
  ExpectRefused({Chunk(10, "abc"), Chunk(11, "def")}, "total_bytes");
}

TEST_F(BlobReaderTest, RefusesEmptyAndOversizedChunks) {
  ExpectRefused({Chunk(10, "")}, "data");
  ExpectRefused({Chunk(2 << 20, std::string((1 << 20) + 1, 'x'))}, "data");
}

TEST_F(BlobReaderTest, RefusesBytesThatAreNoRequest) {
  ExpectRefused({Chunk(3, "\xff\xff\xff")}, "data");
}

TEST_F(BlobReaderTest, RefusesAGigabyteByItsFirstChunk) {
  TestService service;
  EXPECT_EQ(Send(&service, {Chunk(1 << 30, "abc")}).error_code(),
            grpc::StatusCode::RESOURCE_EXHAUSTED);
  EXPECT_EQ(detail_.field(), "total_bytes");
  EXPECT_EQ(detail_.value(), "1073741824");
}

TEST_F(BlobReaderTest, TakesFromTheBudgetAndGivesBack) {
  ServiceLimits limits;
  limits.budget_bytes = 10'000;  // enough for a kilobyte and what parsing makes of it
  TestService service(limits);
  const std::string too_much(10'001, 'x');
  EXPECT_EQ(Send(&service, {Chunk(too_much.size(), too_much)}).error_code(),
            grpc::StatusCode::RESOURCE_EXHAUSTED);
  EXPECT_EQ(detail_.limit(), "10000");
  EXPECT_EQ(Send(&service, {Chunk(1000, std::string(1000, '\xff'))}).error_code(),
            grpc::StatusCode::INVALID_ARGUMENT);
}

TEST_F(BlobReaderTest, AFullQueueIsExhaustion) {
  ServiceLimits limits;
  limits.scheduler.max_queued = 0;
  TestService service(limits);
  const std::string blob = Request();
  EXPECT_EQ(Send(&service, {Chunk(blob.size(), blob)}).error_code(),
            grpc::StatusCode::RESOURCE_EXHAUSTED);
}

}  // namespace
}  // namespace cagefit::server
