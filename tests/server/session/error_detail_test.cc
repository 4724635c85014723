#include "server/session/error_detail.h"

#include <gtest/gtest.h>

namespace cagefit::server {
namespace {

TEST(ErrorDetailTest, AStatusWithoutOneHasNone) {
  EXPECT_FALSE(DetailOf(absl::OkStatus()).has_value());
  EXPECT_FALSE(DetailOf(absl::InternalError("broken")).has_value());
}

TEST(ErrorDetailTest, RidesAlongWithCopiesOfTheStatus) {
  const absl::Status status =
      WithDetail(absl::AbortedError("gone"), {"REASON", "field", "value", "limit"});
  const absl::Status copy = status;
  EXPECT_TRUE(absl::IsAborted(copy));
  EXPECT_EQ(copy.message(), "gone");
  const auto detail = DetailOf(copy);
  ASSERT_TRUE(detail.has_value());
  EXPECT_EQ(detail->reason, "REASON");
  EXPECT_EQ(detail->field, "field");
  EXPECT_EQ(detail->value, "value");
  EXPECT_EQ(detail->limit, "limit");
}

TEST(ErrorDetailTest, ALaterDetailReplacesAnEarlierOne) {
  const absl::Status first = WithDetail(absl::AbortedError("gone"), {"A", "field", "value", "5"});
  const auto detail = DetailOf(WithDetail(first, {"B", "", "", ""}));
  ASSERT_TRUE(detail.has_value());
  EXPECT_EQ(detail->reason, "B");
  EXPECT_EQ(detail->field, "");
  EXPECT_EQ(detail->limit, "");
}

TEST(ErrorDetailTest, ALimitNamesFieldValueAndLimit) {
  const absl::Status status = LimitExceeded("points", 17, 16);
  EXPECT_TRUE(absl::IsResourceExhausted(status));
  EXPECT_EQ(status.message(), "points is 17; the limit is 16");
  const auto detail = DetailOf(status);
  ASSERT_TRUE(detail.has_value());
  EXPECT_EQ(detail->reason, "LIMIT_EXCEEDED");
  EXPECT_EQ(detail->field, "points");
  EXPECT_EQ(detail->value, "17");
  EXPECT_EQ(detail->limit, "16");
}

TEST(ErrorDetailTest, ALimitThatPassesSaysAfterWhatTime) {
  EXPECT_EQ(DetailOf(LimitExceeded("points", 17, 16))->retry_after, absl::ZeroDuration());
  const absl::Status busy = LimitExceeded("queued fits", 2, 1, absl::Milliseconds(1500));
  EXPECT_EQ(DetailOf(busy)->retry_after, absl::Milliseconds(1500));
}

TEST(ErrorDetailTest, AnInvalidFieldNamesFieldValueAndWhatWasExpected) {
  const absl::Status status = InvalidField("levels", "9", "expected 0 to 5");
  EXPECT_TRUE(absl::IsInvalidArgument(status));
  EXPECT_EQ(status.message(), "levels is 9; expected 0 to 5");
  const auto detail = DetailOf(status);
  ASSERT_TRUE(detail.has_value());
  EXPECT_EQ(detail->reason, "INVALID_FIELD");
  EXPECT_EQ(detail->field, "levels");
  EXPECT_EQ(detail->value, "9");
}

TEST(ErrorDetailTest, AFieldOfCoreIsNamedWithWhatItStandsIn) {
  const absl::Status status = InvalidFieldIn("options.fit.", "radius is -1; from 0 to 1");
  EXPECT_TRUE(absl::IsInvalidArgument(status)) << status;
  EXPECT_EQ(status.message(), "options.fit.radius is -1; from 0 to 1");
  EXPECT_EQ(DetailOf(status)->reason, "INVALID_FIELD");
  EXPECT_EQ(DetailOf(status)->field, "options.fit.radius");
  EXPECT_EQ(DetailOf(status)->value, "-1");
  EXPECT_EQ(DetailOf(InvalidFieldIn("header.", "place is nowhere"))->value, "nowhere");
}

}  // namespace
}  // namespace cagefit::server
