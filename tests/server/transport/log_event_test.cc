#include "server/transport/log_event.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace cagefit::server {
namespace {

TEST(LogEventTest, IsAWordAndFields) {
  EXPECT_EQ(LogEvent("frame")
                .Add("session", "ab12")
                .AddInteger("frame", std::numeric_limits<uint64_t>::max())
                .AddNumber("ms", 1234.5678)
                .text(),
            "frame session=ab12 frame=18446744073709551615 ms=1234.57");
}

TEST(LogEventTest, AValueStaysOneValueOfOneLine) {
  EXPECT_EQ(LogEvent("e").Add("v", "a b").text(), R"(e v="a b")");
  EXPECT_EQ(LogEvent("e").Add("v", "").text(), R"(e v="")");
  EXPECT_EQ(LogEvent("e").Add("v", "a=b").text(), R"(e v="a=b")");
  EXPECT_EQ(LogEvent("e").Add("v", "\" x=\"1\n\\").text(), R"(e v="\" x=\"1\n\\")");
  EXPECT_EQ(LogEvent("e").Add("v", "\x1b[31m\x7f\xff").text(), R"(e v="\033[31m\177\377")");
}

TEST(LogEventTest, TextThatLooksLikeANumberIsQuoted) {
  EXPECT_EQ(LogEvent("e").Add("v", "12e4").text(), R"(e v="12e4")");
  EXPECT_EQ(LogEvent("e").Add("v", "-1").text(), R"(e v="-1")");
  EXPECT_EQ(LogEvent("e").Add("v", "66cb6ecb").text(), "e v=66cb6ecb");
  EXPECT_EQ(LogEvent("e").Add("v", "ipv4:127.0.0.1:1").text(), "e v=ipv4:127.0.0.1:1");
}

TEST(LogEventTest, NumbersThatAreNoneAreText) {
  EXPECT_EQ(LogEvent("e").AddNumber("v", std::nan("")).text(), R"(e v="nan")");
  EXPECT_EQ(LogEvent("e").AddNumber("v", -INFINITY).text(), R"(e v="-inf")");
}

}  // namespace
}  // namespace cagefit::server
