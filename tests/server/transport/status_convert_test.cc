#include "server/transport/status_convert.h"

#include <gtest/gtest.h>

#include "server/session/error_detail.h"
#include "tests/server/transport/service_fixture.h"

namespace cagefit::server {
namespace {

TEST(StatusConvertTest, CodesAndMessagesStayTheSame) {
  for (int code = 1; code <= 16; ++code) {
    grpc::CallbackServerContext context;
    const absl::Status status(static_cast<absl::StatusCode>(code), "why");
    const grpc::Status converted = ToGrpc(status, &context);
    EXPECT_EQ(converted.error_code(), code);
    EXPECT_EQ(converted.error_message(), "why");
    EXPECT_EQ(ToProto(status).code(), code);
    EXPECT_EQ(ToProto(status).message(), "why");
    EXPECT_FALSE(ToProto(status).has_detail());
  }
  grpc::CallbackServerContext context;
  EXPECT_TRUE(ToGrpc(absl::OkStatus(), &context).ok());
}

TEST(StatusConvertTest, AFramesErrorCarriesTheDetail) {
  const v1::FrameError error =
      ToProto(WithDetail(absl::InternalError("why"), {"REASON", "field", "value", "limit"}));
  EXPECT_EQ(error.detail().reason(), "REASON");
  EXPECT_EQ(error.detail().field(), "field");
  EXPECT_EQ(error.detail().value(), "value");
  EXPECT_EQ(error.detail().limit(), "limit");
}

TEST(StatusConvertTest, LongTextsAreCutToWhatHeadersTake) {
  const std::string endless(100'000, 'x');
  const absl::Status status =
      WithDetail(absl::InternalError(endless), {"REASON", endless, endless, endless});
  grpc::CallbackServerContext context;
  EXPECT_LE(ToGrpc(status, &context).error_message().size(), 2000u);
  EXPECT_LE(ToProto(status).ByteSizeLong(), 3000u);
}

TEST(StatusConvertTest, TheDetailArrivesInTheTrailer) {
  testing::TestService service;
  testing::BoundedContext context;
  v1::GetSessionRequest request;
  request.set_session_id("nobody");
  v1::Session session;
  EXPECT_EQ(service.stub->GetSession(&context, request, &session).error_code(),
            grpc::StatusCode::NOT_FOUND);
  EXPECT_EQ(testing::DetailOf(context).reason(), "NO_SESSION");
  EXPECT_EQ(testing::DetailOf(context).value(), "nobody");
}

TEST(StatusConvertTest, AnEndlessDetailStillArrives) {
  testing::TestService service;
  testing::BoundedContext context;
  v1::GetSessionRequest request;
  request.set_session_id(std::string(100'000, '\x01'));
  v1::Session session;
  EXPECT_EQ(service.stub->GetSession(&context, request, &session).error_code(),
            grpc::StatusCode::NOT_FOUND);
  EXPECT_EQ(testing::DetailOf(context).reason(), "NO_SESSION");
}

}  // namespace
}  // namespace cagefit::server
