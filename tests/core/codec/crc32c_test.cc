#include "core/codec/crc32c.h"

#include <gtest/gtest.h>

#include <string>

namespace cagefit {
namespace {

TEST(Crc32cTest, GivesTheValuesOfTheStandard) {
  // RFC 3720, B.4, and the check value of every catalogue.
  EXPECT_EQ(Crc32c("123456789"), 0xE3069283u);
  EXPECT_EQ(Crc32c(std::string(32, '\0')), 0x8A9136AAu);
  EXPECT_EQ(Crc32c(std::string(32, '\xFF')), 0x62A8AB43u);
  EXPECT_EQ(Crc32c(""), 0u);
}

}  // namespace
}  // namespace cagefit
