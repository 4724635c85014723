// The seeds of a target as files, which libFuzzer begins with.
#ifndef CAGEFIT_TESTS_FUZZ_SEED_FOLDER_H_
#define CAGEFIT_TESTS_FUZZ_SEED_FOLDER_H_

#include <filesystem>
#include <fstream>
#include <string>

#include "tests/fuzz/fuzz_target.h"

namespace cagefit::testing {

inline void WriteSeeds(const std::string& folder) {
  std::filesystem::create_directories(folder);
  int number = 0;
  for (const std::string& seed : FuzzSeeds()) {
    std::ofstream(folder + "/seed" + std::to_string(number++), std::ios::binary) << seed;
  }
}

}  // namespace cagefit::testing

#endif  // CAGEFIT_TESTS_FUZZ_SEED_FOLDER_H_
