#include "server/transport/message_parts.h"

#include <google/protobuf/descriptor.h>
#include <google/protobuf/io/coded_stream.h>
#include <google/protobuf/wire_format_lite.h>

#include <cstdint>

#include "absl/strings/str_cat.h"
#include "server/session/error_detail.h"

namespace cagefit::server {
namespace {

using google::protobuf::Descriptor;
using google::protobuf::FieldDescriptor;
using google::protobuf::internal::WireFormatLite;
using google::protobuf::io::CodedInputStream;

constexpr int kMaxDepth = 100;  // as protobuf's

// Adds to `parts` until the end of the message, until there are too many, or until something is
// wrong, which the parser will find, too. False then.
bool CountParts(const Descriptor& type, int depth, CodedInputStream* in, int* parts) {
  while (const uint32_t tag = in->ReadTag()) {
    if (WireFormatLite::GetTagWireType(tag) == WireFormatLite::WIRETYPE_START_GROUP) {
      *parts = kMaxParts + 1;  // no message of ours has one; it may hold any number of fields
      return false;
    }
    const FieldDescriptor* field = type.FindFieldByNumber(WireFormatLite::GetTagFieldNumber(tag));
    const bool is_message =
        field != nullptr && field->cpp_type() == FieldDescriptor::CPPTYPE_MESSAGE &&
        WireFormatLite::GetTagWireType(tag) == WireFormatLite::WIRETYPE_LENGTH_DELIMITED;
    if ((is_message || field == nullptr) && ++*parts > kMaxParts) return false;
    if (!is_message) {
      if (!WireFormatLite::SkipField(in, tag)) return false;
      continue;
    }
    uint32_t length = 0;
    if (depth == kMaxDepth || !in->ReadVarint32(&length)) return false;
    const CodedInputStream::Limit limit = in->PushLimit(static_cast<int>(length));
    if (!CountParts(*field->message_type(), depth + 1, in, parts)) return false;
    in->PopLimit(limit);
  }
  return true;
}

}  // namespace

absl::Status ParseParts(const char* field, absl::string_view bytes,
                        google::protobuf::Message* message) {
  const int size = static_cast<int>(bytes.size());
  CodedInputStream in(reinterpret_cast<const uint8_t*>(bytes.data()), size);
  int parts = 0;
  CountParts(*message->GetDescriptor(), 0, &in, &parts);
  if (parts > kMaxParts) {
    return InvalidField(field, absl::StrCat("more than ", kMaxParts, " parts long"),
                        "no request has as many");
  }
  if (message->ParseFromArray(bytes.data(), size)) return absl::OkStatus();
  const std::string& name = message->GetDescriptor()->name();
  const bool has_vowel = absl::string_view("AEIOU").find(name.front()) != absl::string_view::npos;
  return InvalidField(field, absl::StrCat(has_vowel ? "not an " : "not a ", name),
                      "expected one, serialized");
}

absl::Status ParseParts(const char* field, const grpc::ByteBuffer& bytes,
                        google::protobuf::Message* message) {
  grpc::Slice slice;
  if (!bytes.DumpToSingleSlice(&slice).ok()) {
    return absl::InternalError(absl::StrCat(field, ": no bytes"));
  }
  return ParseParts(field, {reinterpret_cast<const char*>(slice.begin()), slice.size()}, message);
}

grpc::ByteBuffer Serialized(const google::protobuf::Message& message) {
  const grpc::Slice slice(message.SerializeAsString());
  return {&slice, 1};
}

}  // namespace cagefit::server
