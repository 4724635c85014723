// Points in time on the wire.
#ifndef CAGEFIT_SERVER_TRANSPORT_TIME_CONVERT_H_
#define CAGEFIT_SERVER_TRANSPORT_TIME_CONVERT_H_

#include <google/protobuf/timestamp.pb.h>

#include <string>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/time/time.h"
#include "server/session/error_detail.h"

namespace cagefit::server {

inline google::protobuf::Timestamp ToProto(absl::Time time) {
  const int64_t seconds = absl::ToUnixSeconds(time);
  google::protobuf::Timestamp proto;
  proto.set_seconds(seconds);
  proto.set_nanos(
      static_cast<int32_t>(absl::ToInt64Nanoseconds(time - absl::FromUnixSeconds(seconds))));
  return proto;
}

inline absl::Time FromProto(const google::protobuf::Timestamp& proto) {
  return absl::FromUnixSeconds(proto.seconds()) + absl::Nanoseconds(proto.nanos());
}

// INVALID_ARGUMENT naming `field` outside what google.protobuf.Timestamp allows: the years 1 to
// 9999.
inline absl::Status CheckTimestamp(const std::string& field,
                                   const google::protobuf::Timestamp& proto) {
  constexpr int64_t kLeast = -62'135'596'800, kMost = 253'402'300'799;
  if (proto.seconds() >= kLeast && proto.seconds() <= kMost && proto.nanos() >= 0 &&
      proto.nanos() <= 999'999'999) {
    return absl::OkStatus();
  }
  return InvalidField(field, absl::StrCat(proto.seconds(), " s and ", proto.nanos(), " ns"),
                      "expected seconds of the years 1 to 9999, and 0 to 999,999,999 ns");
}

}  // namespace cagefit::server

#endif  // CAGEFIT_SERVER_TRANSPORT_TIME_CONVERT_H_
