// How many parts a serialized message has, before it is parsed: a part costs two bytes on the wire,
// and a hundred times that in memory.
#ifndef CAGEFIT_SERVER_TRANSPORT_MESSAGE_PARTS_H_
#define CAGEFIT_SERVER_TRANSPORT_MESSAGE_PARTS_H_

#include <google/protobuf/message.h>
#include <grpcpp/support/byte_buffer.h>

#include "absl/status/status.h"
#include "absl/strings/string_view.h"

namespace cagefit::server {

// Messages inside the message, at any depth, and fields that are not known. Nothing that the
// service has a use for comes near.
inline constexpr int kMaxParts = 100'000;

// Parses `bytes`, then at most 16 times as large, and 20 MB. INVALID_ARGUMENT naming `field` for
// more parts, or bytes that are no such message.
absl::Status ParseParts(const char* field, absl::string_view bytes,
                        google::protobuf::Message* message);
absl::Status ParseParts(const char* field, const grpc::ByteBuffer& bytes,
                        google::protobuf::Message* message);

grpc::ByteBuffer Serialized(const google::protobuf::Message& message);

}  // namespace cagefit::server

#endif  // CAGEFIT_SERVER_TRANSPORT_MESSAGE_PARTS_H_
