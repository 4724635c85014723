// Bytes near good ones. Seeded.
#ifndef CAGEFIT_TESTS_FUZZ_MUTATION_H_
#define CAGEFIT_TESTS_FUZZ_MUTATION_H_

#include <algorithm>
#include <cstdint>
#include <random>
#include <string>
#include <vector>

namespace cagefit::testing {

inline void MutateOnce(const std::vector<std::string>& seeds, std::mt19937_64* random,
                       std::string* bytes) {
  const auto below = [random](size_t n) { return static_cast<size_t>((*random)() % n); };
  const size_t at = below(bytes->size() + 1);
  const size_t left = bytes->size() - at;
  switch (below(7)) {
    case 0:  // another byte
      if (left > 0) (*bytes)[at] = static_cast<char>((*random)());
      return;
    case 1:  // another bit
      if (left > 0) (*bytes)[at] = static_cast<char>((*bytes)[at] ^ (1 << below(8)));
      return;
    case 2:  // cut off
      bytes->resize(at);
      return;
    case 3:  // a piece left out
      bytes->erase(at, below(left + 1));
      return;
    case 4:  // a piece doubled
      bytes->insert(at, bytes->substr(at, below(std::min<size_t>(left, 64) + 1)));
      return;
    case 5: {  // a piece of another seed
      const std::string& other = seeds[below(seeds.size())];
      const size_t from = below(other.size() + 1);
      bytes->insert(at, other.substr(from, below(64)));
      return;
    }
    default: {  // a number of a kind that is seldom expected
      static const std::string kNumbers[] = {std::string(4, '\0'),
                                             std::string(4, '\xff'),
                                             std::string("\xff\xff\xff\x7f", 4),
                                             std::string("\x00\x00\x00\x80", 4),
                                             "-1",
                                             "1e308",
                                             "nan",
                                             "4294967296"};
      const std::string& number = kNumbers[below(std::size(kNumbers))];
      bytes->replace(at, std::min(left, number.size()), number);
    }
  }
}

inline std::string Mutated(const std::vector<std::string>& seeds, std::mt19937_64* random) {
  std::string bytes = seeds[(*random)() % seeds.size()];
  for (uint64_t k = 1 + (*random)() % 6; k > 0; --k) MutateOnce(seeds, random, &bytes);
  return bytes;
}

}  // namespace cagefit::testing

#endif  // CAGEFIT_TESTS_FUZZ_MUTATION_H_
