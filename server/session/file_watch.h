// Tells when files get new contents.
#ifndef CAGEFIT_SERVER_SESSION_FILE_WATCH_H_
#define CAGEFIT_SERVER_SESSION_FILE_WATCH_H_

#include <condition_variable>
#include <functional>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "server/session/digest.h"

namespace cagefit::server {

// The bytes of some files, in the order of their paths, or the first error.
using FileContents = absl::StatusOr<std::vector<std::string>>;

// FAILED_PRECONDITION naming a file that cannot be read, is larger than 1 MiB, or is none.
FileContents ReadFiles(const std::vector<std::string>& paths);

// A thread of its own looks at the files every `interval` and calls `changed` with what they hold
// when that is not what it was before; also when they cannot be read any more. Links are followed,
// so a whole folder may be replaced by turning a link.
class FileWatch {
 public:
  using ChangedFn = std::function<void(const FileContents&)>;

  // `first`: what the files held when the caller read them.
  FileWatch(std::vector<std::string> paths, const FileContents& first, absl::Duration interval,
            ChangedFn changed);
  // Waits for a call of `changed` to return.
  ~FileWatch();
  FileWatch(const FileWatch&) = delete;
  FileWatch& operator=(const FileWatch&) = delete;

 private:
  void Watch();

  const std::vector<std::string> paths_;
  const absl::Duration interval_;
  const ChangedFn changed_;
  Digest seen_;  // of the contents: keys are not kept longer than needed
  std::mutex mutex_;
  std::condition_variable wake_;
  bool ending_ = false;
  std::thread thread_;
};

}  // namespace cagefit::server

#endif  // CAGEFIT_SERVER_SESSION_FILE_WATCH_H_
