// Runs a fuzz target without libFuzzer: on files, or on its seeds and on mutations of them.
//
//   fuzz_NAME [--runs 3000] [--seed 1]      prints what reproduces a crash
//   fuzz_NAME FILE...
#include <CLI/CLI.hpp>
#include <fstream>
#include <iostream>
#include <iterator>
#include <random>

#include "tests/fuzz/fuzz_target.h"
#include "tests/fuzz/mutation.h"

namespace cagefit::testing {
namespace {

struct Options {
  uint64_t runs = 3000;
  uint64_t seed = 1;
  std::vector<std::string> files;
};

void RunOn(const std::string& bytes) {
  LLVMFuzzerTestOneInput(reinterpret_cast<const uint8_t*>(bytes.data()), bytes.size());
}

void RunOnFiles(const std::vector<std::string>& paths) {
  for (const std::string& path : paths) {
    std::ifstream file(path, std::ios::binary);
    RunOn(std::string(std::istreambuf_iterator<char>(file), {}));
  }
}

// Each mutation follows from its own number, which a crash leaves on standard error.
void RunOnMutations(const Options& options) {
  const std::vector<std::string> seeds = FuzzSeeds();
  RunOn("");
  for (const std::string& seed : seeds) RunOn(seed);
  for (uint64_t run = options.seed; run < options.seed + options.runs; ++run) {
    std::mt19937_64 random(run);
    const std::string bytes = Mutated(seeds, &random);
    std::cerr << "\rreproduce: --runs 1 --seed " << run << std::flush;
    RunOn(bytes);
  }
  std::cerr << "\r";
  std::cout << seeds.size() << " seeds, " << options.runs << " mutations\n";
}

}  // namespace
}  // namespace cagefit::testing

int main(int argc, char** argv) {
  using namespace cagefit::testing;
  Options options;
  CLI::App app("Runs a fuzz target on files, or on its seeds and on mutations of them.");
  app.add_option("--runs", options.runs, "Mutations")->capture_default_str();
  app.add_option("--seed", options.seed, "Of the first")->capture_default_str();
  app.add_option("files", options.files);
  CLI11_PARSE(app, argc, argv);
  if (options.files.empty()) {
    RunOnMutations(options);
  } else {
    RunOnFiles(options.files);
  }
  return EXIT_SUCCESS;
}
