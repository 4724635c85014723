// Where the tests find real models, scans and sequences, which are not part of the project.
#ifndef CAGEFIT_TESTS_SUPPORT_DATA_H_
#define CAGEFIT_TESTS_SUPPORT_DATA_H_

#include <gtest/gtest.h>

#include <string>

namespace cagefit::testing {

// $CAGEFIT_DATA, or ../shared/data beside the checkout. Empty when there is no such folder.
std::string DataDir();

// True when CAGEFIT_REQUIRE_DATA=1: a test without its data fails instead of skipping.
bool DataRequired();

}  // namespace cagefit::testing

// First line of a test on real data: skips with a notice, or fails with CAGEFIT_REQUIRE_DATA=1,
// where it is absent.
#define CAGEFIT_NEEDS_DATA()                                                              \
  do {                                                                                    \
    if (::cagefit::testing::DataDir().empty()) {                                          \
      if (::cagefit::testing::DataRequired()) FAIL() << "no test data; set CAGEFIT_DATA"; \
      GTEST_SKIP() << "no test data; set CAGEFIT_DATA";                                   \
    }                                                                                     \
  } while (false)

#endif  // CAGEFIT_TESTS_SUPPORT_DATA_H_
