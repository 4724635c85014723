#include "server/transport/message_parts.h"

#include <gtest/gtest.h>

#include <string>

#include "cagefit/v1/fitting.pb.h"
#include "server/session/error_detail.h"

namespace cagefit::server {
namespace {

// `count` empty fields of length 0, two bytes each.
std::string EmptyFields(int number, int count) {
  std::string wire;
  for (int k = 0; k < count; ++k) {
    wire += static_cast<char>(number << 3 | 2);
    wire += '\0';
  }
  return wire;
}

absl::Status Parse(const std::string& wire) {
  v1::SessionOptions options;  // field 7: cameras; 15: none
  return ParseParts("data", wire, &options);
}

TEST(MessagePartsTest, ReadsWhatTheParserReads) {
  v1::CreateSessionRequest request;
  request.set_name("a rig");
  for (int k = 0; k < 64; ++k) request.mutable_options()->add_cameras()->set_name("c");
  for (int k = 0; k < 300'000; ++k) request.mutable_control_mesh()->add_triangles(k);
  v1::CreateSessionRequest parsed;
  EXPECT_EQ(ParseParts("data", request.SerializeAsString(), &parsed), absl::OkStatus());
  EXPECT_EQ(parsed.SerializeAsString(), request.SerializeAsString());
}

TEST(MessagePartsTest, RefusesMorePartsThanAnyRequestHas) {
  for (const int number : {7, 15}) {
    EXPECT_EQ(Parse(EmptyFields(number, kMaxParts)), absl::OkStatus());
    const absl::Status refused = Parse(EmptyFields(number, kMaxParts + 1));
    EXPECT_TRUE(absl::IsInvalidArgument(refused)) << refused;
    EXPECT_EQ(DetailOf(refused)->field, "data");
  }
}

TEST(MessagePartsTest, CountsPartsOfParts) {
  v1::CreateSessionRequest request;
  for (int k = 0; k <= kMaxParts; ++k) request.mutable_options()->add_cameras();
  v1::CreateSessionRequest parsed;
  EXPECT_FALSE(ParseParts("data", request.SerializeAsString(), &parsed).ok());
}

TEST(MessagePartsTest, RefusesGroups) {
  // Of a field that is not known: begin and end, nothing between.
  const std::string group = {static_cast<char>(15 << 3 | 3), static_cast<char>(15 << 3 | 4)};
  EXPECT_TRUE(absl::IsInvalidArgument(Parse(group)));
}

TEST(MessagePartsTest, RefusesBytesThatAreNoMessage) {
  for (const std::string& wire :
       {std::string("\x3a\x7f"), std::string("\xff\xff\xff"), std::string(100, '\x3a')}) {
    const absl::Status refused = Parse(wire);
    EXPECT_TRUE(absl::IsInvalidArgument(refused)) << refused;
    EXPECT_EQ(DetailOf(refused)->value, "not a SessionOptions");
  }
}

}  // namespace
}  // namespace cagefit::server
