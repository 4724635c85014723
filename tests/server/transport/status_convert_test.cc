#include "server/transport/status_convert.h"

#include <gtest/gtest.h>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
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

// A reply with another string in it could not be read at all.
TEST(StatusConvertTest, AFramesErrorIsAlwaysUtf8) {
  const std::string sharp_s = "\xc3\x9f", euro = "\xe2\x82\xac", clef = "\xf0\x9d\x84\x9e";
  const std::string good = "a" + sharp_s + euro + clef;
  EXPECT_EQ(ToProto(absl::InternalError(good)).message(), good);
  // A byte alone, sequences cut short, one too long for its character, a surrogate, beyond Unicode.
  for (const char* bad : {"\xff", "\x80", "\xc3", "\xe2\x82", "\xf0\x9d\x84", "\xc0\xaf",
                          "\xe0\x80\xaf", "\xed\xa0\x80", "\xf4\x90\x80\x80"}) {
    const v1::FrameError error = ToProto(
        WithDetail(absl::InternalError(absl::StrCat(good, bad)), {"REASON", "field", bad, ""}));
    EXPECT_EQ(error.message(), good + std::string(std::string(bad).size(), '?'));
    v1::FrameError parsed;
    EXPECT_TRUE(parsed.ParseFromString(error.SerializeAsString()));
  }
  // Cut between characters.
  std::string long_text = "x";
  for (int k = 0; k < 1000; ++k) long_text += euro;
  EXPECT_TRUE(ToProto(absl::InternalError(long_text)).message() ==
              long_text.substr(0, 1 + 3 * 666));
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

TEST(StatusConvertTest, ARetryTimeIsSetOnlyWhereThereIsOne) {
  EXPECT_FALSE(ToProto(LimitExceeded("points", 17, 16)).detail().has_retry_after());
  const v1::FrameError error =
      ToProto(LimitExceeded("queued fits", 2, 1, absl::Milliseconds(1500)));
  EXPECT_EQ(error.detail().retry_after().seconds(), 1);
  EXPECT_EQ(error.detail().retry_after().nanos(), 500'000'000);
}

TEST(StatusConvertTest, ACancelledCallNamesItsDeadlineWhereThatIsTheCause) {
  const absl::Status cancelled = absl::CancelledError("gone");
  EXPECT_TRUE(absl::IsDeadlineExceeded(NamingDeadline(cancelled, absl::Now())));
  EXPECT_EQ(NamingDeadline(cancelled, absl::Now() + absl::Seconds(9)), cancelled);
  EXPECT_EQ(NamingDeadline(cancelled, absl::InfiniteFuture()), cancelled);
  const absl::Status other = absl::AbortedError("overtaken");
  EXPECT_EQ(NamingDeadline(other, absl::Now()), other);
}

}  // namespace
}  // namespace cagefit::server
