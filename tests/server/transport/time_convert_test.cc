#include "server/transport/time_convert.h"

#include <gtest/gtest.h>

namespace cagefit::server {
namespace {

TEST(TimeConvertTest, NanosecondsAreNeverNegative) {
  const google::protobuf::Timestamp before_1970 = ToProto(absl::FromUnixNanos(-1));
  EXPECT_EQ(before_1970.seconds(), -1);
  EXPECT_EQ(before_1970.nanos(), 999'999'999);
}

TEST(TimeConvertTest, ComesBackToTheNanosecond) {
  for (const int64_t nanos : {int64_t{0}, int64_t{1}, int64_t{-1}, int64_t{1'700'000'000'123456789},
                              int64_t{-1'700'000'000'123456789}}) {
    EXPECT_EQ(FromProto(ToProto(absl::FromUnixNanos(nanos))), absl::FromUnixNanos(nanos));
  }
}

TEST(TimeConvertTest, RefusesWhatIsNoTimestamp) {
  const auto check = [](int64_t seconds, int32_t nanos) {
    google::protobuf::Timestamp proto;
    proto.set_seconds(seconds);
    proto.set_nanos(nanos);
    return CheckTimestamp("time", proto);
  };
  EXPECT_EQ(check(-62'135'596'800, 0), absl::OkStatus());
  EXPECT_EQ(check(253'402'300'799, 999'999'999), absl::OkStatus());
  EXPECT_EQ(check(0, -1).message(),
            "time is 0 s and -1 ns; expected seconds of the years 1 to 9999, and 0 to 999,999,999 "
            "ns");
  for (const absl::Status& status :
       {check(-62'135'596'801, 0), check(253'402'300'800, 0), check(0, 1'000'000'000)}) {
    EXPECT_TRUE(absl::IsInvalidArgument(status)) << status;
  }
}

}  // namespace
}  // namespace cagefit::server
