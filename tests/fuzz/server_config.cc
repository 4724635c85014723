// Any file of settings: refused with an exit code, or settings within their ranges.
#include <sys/mman.h>
#include <unistd.h>

#include <iostream>

#include "absl/strings/str_cat.h"
#include "server/server_options.h"
#include "tests/fuzz/fuzz_target.h"

namespace cagefit::testing {
namespace {

// Errors and help go nowhere.
void Silence() {
  static const bool done = [] {
    std::cerr.rdbuf(nullptr);
    std::cout.rdbuf(nullptr);
    return true;
  }();
  static_cast<void>(done);
}

}  // namespace

std::vector<std::string> FuzzSeeds() {
  return {"max-points=100000\nmax-frame-mib = 8\n",
          "listen=[127.0.0.1:1, unix:/tmp/x]\nlog-level=\"debug\"\n# a comment\n",
          "template-seconds=1.5\nthreads=4\nfits=0\ndrain-seconds=0\n",
          "[section]\nmax-sessions=1\n\nlisten=127.0.0.1:0\nlisten=127.0.0.1:2\n",
          "max-points=16\n; old comment\nmax-history-mib=1_000\nhelp=true\n"};
}

}  // namespace cagefit::testing

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace cagefit::testing;
  Silence();
  static const int file = memfd_create("config", MFD_CLOEXEC);
  FUZZ_CHECK(file >= 0 && ftruncate(file, 0) == 0);
  FUZZ_CHECK(pwrite(file, data, size, 0) == static_cast<ssize_t>(size));
  const std::string path = absl::StrCat("/proc/self/fd/", file);
  const char* const arguments[] = {"cagefitd", "--config", path.c_str()};
  const auto parsed = cagefit::server::ParseServerOptions(3, arguments);
  FUZZ_CHECK(parsed.exit_code.has_value() || parsed.options.Validate().ok());
  FUZZ_CHECK(!parsed.exit_code.has_value() || *parsed.exit_code == 0 || *parsed.exit_code == 2);
  return 0;
}
