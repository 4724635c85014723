#include "core/base/instruction_set.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace cagefit {
namespace {

TEST(InstructionSetTest, HasAName) {
  EXPECT_THAT(InstructionSetName(), ::testing::MatchesRegex("[A-Z][A-Z0-9_]+"));
  EXPECT_THAT(InstructionSetName(), ::testing::Not(::testing::StrCaseEq("unknown")));
}

}  // namespace
}  // namespace cagefit
