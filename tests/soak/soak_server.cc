#include "tests/soak/soak_server.h"

#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <utility>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"

namespace cagefit::testing {
namespace {

std::string NewFolder() {
  std::string path = (std::filesystem::temp_directory_path() / "cagefit_soak.XXXXXX").string();
  return mkdtemp(path.data()) != nullptr ? path : "/nowhere";
}

}  // namespace

SoakServer::SoakServer(std::string program, std::vector<std::string> arguments)
    : program_(std::move(program)),
      folder_(NewFolder()),
      address_(absl::StrCat("unix:", folder_, "/socket")),
      arguments_(std::move(arguments)) {
  if (std::find(arguments_.begin(), arguments_.end(), "--store") == arguments_.end()) {
    arguments_.insert(arguments_.end(), {"--store", "memory"});
  }
  arguments_.insert(arguments_.begin(), {"--listen", address_, "--log-level", "error"});
}

SoakServer::~SoakServer() {
  Kill();
  std::error_code ignored;
  std::filesystem::remove_all(folder_, ignored);
}

absl::Status SoakServer::Start() {
  running_ = std::make_unique<RunningProgram>(program_, arguments_);
  const std::string line = running_->ReadLine();
  if (absl::StartsWith(line, "listening on ")) return absl::OkStatus();
  return absl::UnavailableError(absl::StrCat(program_, " does not start: ", line));
}

int SoakServer::Terminate() {
  running_->Signal(SIGTERM);
  return running_->Wait();
}

double SoakServer::CpuSeconds() const { return running_->CpuSeconds(); }

void SoakServer::Kill() { running_.reset(); }

}  // namespace cagefit::testing
