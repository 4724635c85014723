// What a sanitizer costs.
#ifndef CAGEFIT_TESTS_SUPPORT_SANITIZER_H_
#define CAGEFIT_TESTS_SUPPORT_SANITIZER_H_

#include "core/base/sanitizer.h"

namespace cagefit::testing {

inline constexpr bool kIsSanitized = CAGEFIT_ADDRESS_SANITIZER || CAGEFIT_THREAD_SANITIZER;
// Of memory and time, beside what they are without.
inline constexpr double kCostFactor = kIsSanitized ? 20 : 1;

}  // namespace cagefit::testing

#endif  // CAGEFIT_TESTS_SUPPORT_SANITIZER_H_
