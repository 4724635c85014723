#include "client/status_from_grpc.h"

#include <gtest/gtest.h>

#include "client/embedded_server.h"
#include "client/fit_client.h"

namespace cagefit::client {
namespace {

TEST(StatusFromGrpcTest, CodesAndMessagesStayTheSame) {
  const grpc::ClientContext context;
  EXPECT_EQ(FromGrpc(grpc::Status::OK, context), absl::OkStatus());
  for (int code = 1; code <= 16; ++code) {
    const absl::Status status =
        FromGrpc(grpc::Status(static_cast<grpc::StatusCode>(code), "why"), context);
    EXPECT_EQ(status.raw_code(), code);
    EXPECT_EQ(status.message(), "why");
    EXPECT_FALSE(DetailOf(status).has_value());
  }
}

TEST(StatusFromGrpcTest, AFramesErrorKeepsItsDetail) {
  v1::FrameError error;
  error.set_code(static_cast<int>(absl::StatusCode::kInvalidArgument));
  error.set_message("why");
  EXPECT_FALSE(DetailOf(FromProto(error)).has_value());
  error.mutable_detail()->set_reason("REASON");
  error.mutable_detail()->set_value(std::string("a\0b", 3));
  const absl::Status status = FromProto(error);
  EXPECT_TRUE(absl::IsInvalidArgument(status)) << status;
  EXPECT_EQ(status.message(), "why");
  ASSERT_TRUE(DetailOf(status).has_value());
  EXPECT_EQ(DetailOf(status)->reason(), "REASON");
  EXPECT_EQ(DetailOf(status)->value(), std::string("a\0b", 3));
}

TEST(StatusFromGrpcTest, AServersDetailComesFromItsTrailer) {
  const auto server = EmbeddedServer::Start(1);
  ASSERT_TRUE(server.ok()) << server.status();
  const auto client = FitClient::Connect({(*server)->address()});
  ASSERT_TRUE(client.ok()) << client.status();
  const absl::Status status = (*client)->GetSession("nobody").status();
  EXPECT_TRUE(absl::IsNotFound(status)) << status;
  ASSERT_TRUE(DetailOf(status).has_value());
  EXPECT_EQ(DetailOf(status)->reason(), "NO_SESSION");
  EXPECT_EQ(DetailOf(status)->value(), "nobody");
}

}  // namespace
}  // namespace cagefit::client
