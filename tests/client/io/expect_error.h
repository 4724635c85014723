// One-line checks of readers' errors.
#ifndef CAGEFIT_TESTS_CLIENT_IO_EXPECT_ERROR_H_
#define CAGEFIT_TESTS_CLIENT_IO_EXPECT_ERROR_H_

#include <gmock/gmock.h>

#include <string>

#include "absl/status/statusor.h"

// `result` failed as INVALID_ARGUMENT with a message that holds `part`.
#define EXPECT_INVALID(result, part)                                        \
  do {                                                                      \
    const absl::Status status = (result).status();                          \
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument) << status; \
    EXPECT_THAT(std::string(status.message()), ::testing::HasSubstr(part)); \
  } while (false)

#endif  // CAGEFIT_TESTS_CLIENT_IO_EXPECT_ERROR_H_
