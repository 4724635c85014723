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

}  // namespace
}  // namespace cagefit::server
