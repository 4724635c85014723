// Bytes as a broken disk or a hostile client would send them, made from good ones. Seeded.
#ifndef CAGEFIT_TESTS_SUPPORT_SPOILED_BYTES_H_
#define CAGEFIT_TESTS_SUPPORT_SPOILED_BYTES_H_

#include <cstdint>
#include <random>
#include <string>

namespace cagefit::testing {

// Calls visit(bytes) for each shorter beginning of `good`.
template <typename Visit>
void ForEachTruncation(const std::string& good, Visit visit) {
  for (size_t size = 0; size < good.size(); ++size) visit(good.substr(0, size));
}

// Calls visit(bytes) `count` times, each with 1 to 4 bytes of `good` replaced.
template <typename Visit>
void ForEachFlip(const std::string& good, int count, uint32_t seed, Visit visit) {
  std::mt19937 random(seed);
  for (int k = 0; k < count; ++k) {
    std::string bytes = good;
    for (uint32_t flips = 1 + random() % 4; flips > 0; --flips) {
      bytes[random() % bytes.size()] = static_cast<char>(random());
    }
    visit(bytes);
  }
}

}  // namespace cagefit::testing

#endif  // CAGEFIT_TESTS_SUPPORT_SPOILED_BYTES_H_
