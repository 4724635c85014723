// Runs a fuzz target without libFuzzer: on files, or on its seeds and on mutations of them.
//
//   fuzz_NAME [--runs 3000] [--seed 1]      prints what reproduces a crash
//   fuzz_NAME FILE...
#include <signal.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cinttypes>
#include <cstdio>
#include <fstream>
#include <iostream>
#include <iterator>
#include <random>

#include "core/base/sanitizer.h"
#include "tests/fuzz/fuzz_target.h"
#include "tests/fuzz/mutation.h"

#if CAGEFIT_ADDRESS_SANITIZER
extern "C" void __sanitizer_set_death_callback(void (*callback)());
#endif

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

// Of the mutation that is being run, each of which follows from its own number.
uint64_t current_seed = 0;

void WriteSeed() {
  char line[64];
  const int size =
      snprintf(line, sizeof(line), "reproduce: --runs 1 --seed %" PRIu64 "\n", current_seed);
  static_cast<void>(!write(STDERR_FILENO, line, size));
}

[[maybe_unused]] void OnCrash(int signal) {
  WriteSeed();
  raise(signal);  // SA_RESETHAND: for good
}

// The sanitizer handles signals itself, and better.
void ReportCrashes() {
#if CAGEFIT_ADDRESS_SANITIZER
  __sanitizer_set_death_callback(WriteSeed);
#else
  struct sigaction action = {};
  action.sa_handler = OnCrash;
  action.sa_flags = static_cast<int>(SA_RESETHAND | SA_NODEFER);
  for (const int signal : {SIGABRT, SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGTERM}) {
    sigaction(signal, &action, nullptr);
  }
#endif
}

void RunOnMutations(const Options& options) {
  const std::vector<std::string> seeds = FuzzSeeds();
  RunOn("");
  for (const std::string& seed : seeds) RunOn(seed);
  for (uint64_t run = options.seed; run < options.seed + options.runs; ++run) {
    std::mt19937_64 random(run);
    current_seed = run;
    RunOn(Mutated(seeds, &random));
  }
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
    ReportCrashes();
    RunOnMutations(options);
  } else {
    RunOnFiles(options.files);
  }
  return EXIT_SUCCESS;
}
