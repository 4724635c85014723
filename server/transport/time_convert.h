// Points in time on the wire.
#ifndef CAGEFIT_SERVER_TRANSPORT_TIME_CONVERT_H_
#define CAGEFIT_SERVER_TRANSPORT_TIME_CONVERT_H_

#include <google/protobuf/timestamp.pb.h>

#include "absl/time/time.h"

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

}  // namespace cagefit::server

#endif  // CAGEFIT_SERVER_TRANSPORT_TIME_CONVERT_H_
