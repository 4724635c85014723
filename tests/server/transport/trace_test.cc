#include "server/transport/trace.h"

#include <gtest/gtest.h>

namespace cagefit::server {
namespace {

constexpr char kTraceId[] = "4bf92f3577b34da6a3ce929d0e0e4736";
const std::string kGood = "00-4bf92f3577b34da6a3ce929d0e0e4736-00f067aa0ba902b7-01";

TEST(TraceTest, TakesTheTraceIdOfATraceparent) { EXPECT_EQ(ParseTraceparent(kGood), kTraceId); }

TEST(TraceTest, TakesLaterVersionsWithMoreBehindADash) {
  const std::string later = "01" + kGood.substr(2);
  EXPECT_EQ(ParseTraceparent(later), kTraceId);
  EXPECT_EQ(ParseTraceparent(later + "-more"), kTraceId);
  EXPECT_EQ(ParseTraceparent(later + "more"), std::nullopt);
}

TEST(TraceTest, TakesNothingElse) {
  for (const std::string& bad : std::initializer_list<std::string>{
           "", kGood.substr(1), kGood.substr(0, 54), kGood + "-00", kGood + " ",
           "ff" + kGood.substr(2), "0g" + kGood.substr(2),
           "00-4BF92F3577B34DA6A3CE929D0E0E4736-00f067aa0ba902b7-01",
           "00-00000000000000000000000000000000-00f067aa0ba902b7-01",
           "00-4bf92f3577b34da6a3ce929d0e0e4736-0000000000000000-01",
           "00-4bf92f3577b34da6a3ce929d0e0e4736-00f067aa0ba902b7-0x",
           "00_4bf92f3577b34da6a3ce929d0e0e4736-00f067aa0ba902b7-01",
           "00-4bf92f3577b34da6a3ce929d0e0e4736_00f067aa0ba902b7-01",
           "00-4bf92f3577b34da6a3ce929d0e0e4736-00f067aa0ba902b7_01",
           "00-4bf92f3577b34da6a3ce929d0e0e473\n-00f067aa0ba902b7-01"}) {
    EXPECT_EQ(ParseTraceparent(bad), std::nullopt) << bad;
  }
}

}  // namespace
}  // namespace cagefit::server
