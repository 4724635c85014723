// A fuzz target: one file that defines the two functions below. Built with CAGEFIT_FUZZ, libFuzzer
// runs it; otherwise replay.cc does, on the seeds and on mutations of them.
#ifndef CAGEFIT_TESTS_FUZZ_FUZZ_TARGET_H_
#define CAGEFIT_TESTS_FUZZ_FUZZ_TARGET_H_

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

// Takes any bytes. Aborts where a promise is broken.
extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size);

namespace cagefit::testing {

// Good input, of every kind.
std::vector<std::string> FuzzSeeds();

// A broken promise.
#define FUZZ_CHECK(condition)                                                      \
  do {                                                                             \
    if (!(condition)) {                                                            \
      std::fprintf(stderr, "%s:%d: broken: %s\n", __FILE__, __LINE__, #condition); \
      std::abort();                                                                \
    }                                                                              \
  } while (false)

inline std::string BytesOf(const uint8_t* data, size_t size) {
  return std::string(reinterpret_cast<const char*>(data), size);
}

}  // namespace cagefit::testing

#endif  // CAGEFIT_TESTS_FUZZ_FUZZ_TARGET_H_
