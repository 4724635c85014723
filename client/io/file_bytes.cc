#include "client/io/file_bytes.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>

#include "absl/strings/str_cat.h"
#include "core/base/status.h"

namespace cagefit::client {
namespace {

// Pipes and devices have no size: they are read to their end, in steps.
constexpr size_t kStepBytes = 1 << 20;

class OpenFile {
 public:
  explicit OpenFile(int descriptor) : descriptor_(descriptor) {}
  ~OpenFile() {
    if (descriptor_ >= 0) close(descriptor_);
  }
  OpenFile(const OpenFile&) = delete;
  OpenFile& operator=(const OpenFile&) = delete;
  int get() const { return descriptor_; }
  // The result of close.
  bool Close() {
    const int descriptor = descriptor_;
    descriptor_ = -1;
    return close(descriptor) == 0;
  }

 private:
  int descriptor_;
};

absl::Status TooLarge(const std::string& path, int64_t max_bytes) {
  return absl::ResourceExhaustedError(
      absl::StrCat(path, ": more than ", max_bytes, " bytes, which is the limit"));
}

absl::Status Failed(const std::string& path, absl::string_view what) {
  return absl::FailedPreconditionError(absl::StrCat(path, ": ", what, ": ", std::strerror(errno)));
}

absl::Status WriteAll(int descriptor, const std::string& path, absl::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t written = write(descriptor, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return Failed(path, "cannot be written");
    bytes.remove_prefix(static_cast<size_t>(written));
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<std::string> ReadFileBytes(const std::string& path, int64_t max_bytes) {
  const OpenFile file(open(path.c_str(), O_RDONLY | O_CLOEXEC));
  if (file.get() < 0 && errno == ENOENT) {
    return absl::NotFoundError(absl::StrCat(path, ": there is no such file"));
  }
  struct stat info;
  if (file.get() < 0 || fstat(file.get(), &info) != 0) return Failed(path, "cannot be read");
  if (S_ISDIR(info.st_mode)) return absl::InvalidArgumentError(absl::StrCat(path, ": is a folder"));
  if (info.st_size > max_bytes) return TooLarge(path, max_bytes);
  std::string bytes;
  bytes.reserve(static_cast<size_t>(info.st_size) + 1);
  size_t size = 0;
  while (true) {
    bytes.resize(size + kStepBytes);
    const ssize_t got = read(file.get(), bytes.data() + size, kStepBytes);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return Failed(path, "cannot be read");
    size += static_cast<size_t>(got);
    if (got == 0) break;
    if (static_cast<int64_t>(size) > max_bytes) return TooLarge(path, max_bytes);
  }
  bytes.resize(size);
  return bytes;
}

absl::Status WriteFileBytes(const std::string& path, absl::string_view bytes) {
  const std::string beside = absl::StrCat(path, ".", getpid(), ".part");
  OpenFile file(open(beside.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666));
  if (file.get() < 0) return Failed(path, "cannot be written");
  absl::Status status = WriteAll(file.get(), path, bytes);
  if (!file.Close() && status.ok()) status = Failed(path, "cannot be written");
  if (status.ok() && rename(beside.c_str(), path.c_str()) != 0) {
    status = Failed(path, "cannot be written");
  }
  if (!status.ok()) unlink(beside.c_str());
  return status;
}

absl::Status MakeFolder(const std::string& path) {
  std::error_code error;
  std::filesystem::create_directories(path, error);
  if (!error) return absl::OkStatus();
  return absl::FailedPreconditionError(absl::StrCat(path, ": cannot be made: ", error.message()));
}

}  // namespace cagefit::client
