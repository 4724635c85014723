#include "server/session/file_watch.h"

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <utility>

#include "absl/strings/str_cat.h"
#include "core/base/status.h"

namespace cagefit::server {
namespace {

constexpr size_t kMaxFileBytes = 1 << 20;

absl::StatusOr<std::string> ReadFile(const std::string& path) {
  // A pipe would give its bytes once, and then keep the watch waiting.
  std::error_code error;
  const auto status = std::filesystem::status(path, error);
  if (std::filesystem::exists(status) && !std::filesystem::is_regular_file(status)) {
    return absl::FailedPreconditionError(absl::StrCat(path, ": is not a regular file"));
  }
  std::ifstream file(path, std::ios::binary);
  if (!file) {
    return absl::FailedPreconditionError(
        absl::StrCat(path, ": cannot be read: ", std::strerror(errno)));
  }
  std::string bytes;
  char part[1 << 14];
  while (file.read(part, sizeof(part)) || file.gcount() > 0) {
    bytes.append(part, static_cast<size_t>(file.gcount()));
    if (bytes.size() > kMaxFileBytes) {
      return absl::FailedPreconditionError(absl::StrCat(path, ": larger than 1 MiB"));
    }
  }
  if (!file.eof()) return absl::FailedPreconditionError(absl::StrCat(path, ": cannot be read"));
  return bytes;
}

Digest DigestOf(const FileContents& contents) {
  if (!contents.ok()) return Sha256(absl::StrCat("error ", contents.status().message()));
  std::string digests;
  for (const std::string& bytes : *contents) {
    const Digest digest = Sha256(bytes);
    digests.append(digest.begin(), digest.end());
  }
  return Sha256(digests);
}

}  // namespace

FileContents ReadFiles(const std::vector<std::string>& paths) {
  std::vector<std::string> contents;
  for (const std::string& path : paths) {
    ASSIGN_OR_RETURN(std::string bytes, ReadFile(path));
    contents.push_back(std::move(bytes));
  }
  return contents;
}

FileWatch::FileWatch(std::vector<std::string> paths, const FileContents& first,
                     absl::Duration interval, ChangedFn changed)
    : paths_(std::move(paths)),
      interval_(interval),
      changed_(std::move(changed)),
      seen_(DigestOf(first)),
      thread_([this] { Watch(); }) {}

FileWatch::~FileWatch() {
  {
    std::lock_guard<std::mutex> lock(mutex_);
    ending_ = true;
  }
  wake_.notify_all();
  thread_.join();
}

void FileWatch::Watch() {
  std::unique_lock<std::mutex> lock(mutex_);
  while (!wake_.wait_for(lock, absl::ToChronoNanoseconds(interval_), [this] { return ending_; })) {
    lock.unlock();
    // The bytes themselves: times of change are too coarse to tell two writes from one.
    const FileContents contents = ReadFiles(paths_);
    const Digest digest = DigestOf(contents);
    if (digest != seen_) {
      seen_ = digest;
      changed_(contents);
    }
    lock.lock();
  }
}

}  // namespace cagefit::server
