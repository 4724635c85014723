// With CAGEFIT_FUZZ_SEEDS=FOLDER a target only writes its seeds there.
#include <cstdlib>

#include "tests/fuzz/seed_folder.h"

extern "C" int LLVMFuzzerInitialize(int*, char***) {
  const char* folder = std::getenv("CAGEFIT_FUZZ_SEEDS");
  if (folder == nullptr) return 0;
  cagefit::testing::WriteSeeds(folder);
  std::_Exit(EXIT_SUCCESS);
}
