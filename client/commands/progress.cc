#include "client/commands/progress.h"

#include <unistd.h>

#include <iostream>

#include "absl/strings/str_cat.h"

namespace cagefit::client {
namespace {

constexpr size_t kBarWidth = 24;
constexpr char kEraseLine[] = "\r\033[K";

}  // namespace

Progress::Progress(size_t frames) : frames_(frames), terminal_(isatty(STDERR_FILENO) == 1) {}

Progress::~Progress() {
  if (terminal_ && shown_) std::cerr << kEraseLine << std::flush;
}

void Progress::Show(size_t done, const std::string& text) {
  shown_ = true;
  const std::string of = frames_ == 0 ? "" : absl::StrCat(" of ", frames_);
  const std::string count = absl::StrCat("frame ", done, of, ": ", text);
  if (!terminal_) {
    std::cerr << count << "\n";
    return;
  }
  const size_t filled = frames_ == 0 ? 0 : kBarWidth * done / frames_;
  std::cerr << kEraseLine << "[" << std::string(filled, '#') << std::string(kBarWidth - filled, '.')
            << "] " << count << std::flush;
}

}  // namespace cagefit::client
