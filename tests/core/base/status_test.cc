#include "core/base/status.h"

#include <gtest/gtest.h>

#include <memory>

namespace cagefit {
namespace {

absl::StatusOr<std::unique_ptr<int>> Half(int x) {
  if (x % 2 != 0) return absl::InvalidArgumentError("odd");
  return std::make_unique<int>(x / 2);
}

absl::Status Quarter(int x, int* quarter) {
  ASSIGN_OR_RETURN(const std::unique_ptr<int> half, Half(x));
  std::unique_ptr<int> result;
  ASSIGN_OR_RETURN(result, Half(*half));
  *quarter = *result;
  return absl::OkStatus();
}

absl::Status TwiceQuarter(int x, int* calls) {
  int quarter = 0;
  RETURN_IF_ERROR(Quarter(x, &quarter));
  ++*calls;
  return absl::OkStatus();
}

TEST(StatusMacrosTest, AssignMovesTheValueOut) {
  int quarter = 0;
  EXPECT_TRUE(Quarter(12, &quarter).ok());
  EXPECT_EQ(quarter, 3);
}

TEST(StatusMacrosTest, AssignReturnsTheFirstError) {
  int quarter = -1;
  EXPECT_EQ(Quarter(6, &quarter), absl::InvalidArgumentError("odd"));
  EXPECT_EQ(quarter, -1);
}

TEST(StatusMacrosTest, ReturnIfErrorStopsOnlyOnErrors) {
  int calls = 0;
  EXPECT_TRUE(TwiceQuarter(4, &calls).ok());
  EXPECT_EQ(TwiceQuarter(5, &calls), absl::InvalidArgumentError("odd"));
  EXPECT_EQ(calls, 1);
}

}  // namespace
}  // namespace cagefit
