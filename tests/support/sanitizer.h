// Whether this is compiled with a sanitizer, by GCC, which defines macros, or clang, which has
// features.
#ifndef CAGEFIT_TESTS_SUPPORT_SANITIZER_H_
#define CAGEFIT_TESTS_SUPPORT_SANITIZER_H_

#ifdef __has_feature
#define CAGEFIT_HAS_FEATURE(name) __has_feature(name)
#else
#define CAGEFIT_HAS_FEATURE(name) 0
#endif

#if defined(__SANITIZE_ADDRESS__) || CAGEFIT_HAS_FEATURE(address_sanitizer)
#define CAGEFIT_ADDRESS_SANITIZER 1
#endif
#if defined(__SANITIZE_THREAD__) || CAGEFIT_HAS_FEATURE(thread_sanitizer)
#define CAGEFIT_THREAD_SANITIZER 1
#endif

namespace cagefit::testing {

// Of memory and time, beside what they are without.
#if defined(CAGEFIT_ADDRESS_SANITIZER) || defined(CAGEFIT_THREAD_SANITIZER)
inline constexpr bool kIsSanitized = true;
inline constexpr double kCostFactor = 20;
#else
inline constexpr bool kIsSanitized = false;
inline constexpr double kCostFactor = 1;
#endif

}  // namespace cagefit::testing

#endif  // CAGEFIT_TESTS_SUPPORT_SANITIZER_H_
