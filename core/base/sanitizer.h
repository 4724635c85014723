// Whether this is compiled with a sanitizer: by GCC, which defines macros, or clang, which has
// features.
#ifndef CAGEFIT_CORE_BASE_SANITIZER_H_
#define CAGEFIT_CORE_BASE_SANITIZER_H_

#ifdef __has_feature
#define CAGEFIT_HAS_FEATURE(name) __has_feature(name)
#else
#define CAGEFIT_HAS_FEATURE(name) 0
#endif

#if defined(__SANITIZE_ADDRESS__) || CAGEFIT_HAS_FEATURE(address_sanitizer)
#define CAGEFIT_ADDRESS_SANITIZER 1
#else
#define CAGEFIT_ADDRESS_SANITIZER 0
#endif
#if defined(__SANITIZE_THREAD__) || CAGEFIT_HAS_FEATURE(thread_sanitizer)
#define CAGEFIT_THREAD_SANITIZER 1
#else
#define CAGEFIT_THREAD_SANITIZER 0
#endif

#endif  // CAGEFIT_CORE_BASE_SANITIZER_H_
