// The files of a folder as they are completed.
#ifndef CAGEFIT_CLIENT_COMMANDS_FOLDER_FOLLOWER_H_
#define CAGEFIT_CLIENT_COMMANDS_FOLDER_FOLLOWER_H_

#include <atomic>
#include <memory>
#include <optional>
#include <string>

#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "client/commands/folder_watch.h"

namespace cagefit::client {

struct FollowOptions {
  absl::Duration settle = absl::Seconds(1);        // as FolderWatch has it
  absl::Duration idle = absl::InfiniteDuration();  // without a new or changed file: the end
};

class FolderFollower {
 public:
  // Says on standard error that it watches, and until when. FAILED_PRECONDITION, naming the folder,
  // when it cannot be read.
  static absl::StatusOr<std::unique_ptr<FolderFollower>> Open(std::string folder,
                                                              const FollowOptions& options);
  ~FolderFollower();
  FolderFollower(const FolderFollower&) = delete;
  FolderFollower& operator=(const FolderFollower&) = delete;

  // Blocks until the next geometry file is complete; its path. Nothing after Stop, and when the
  // folder was idle for long enough. Says on standard error which files it left out, and why.
  std::optional<std::string> Next();

  // From any thread; then and from then on, Next returns nothing.
  void Stop();

 private:
  FolderFollower(std::string folder, const FollowOptions& options);
  absl::Status Look();
  void ReadRenames();
  void Wait();

  const std::string folder_;
  const FollowOptions options_;
  int notices_ = -1;  // inotify, of renames; -1 where there is none
  int stop_ = -1;     // an event
  std::atomic<bool> stopped_{false};
  const absl::Time begun_;
  FolderWatch watch_;
  std::string format_;  // of the first file, and so of all
};

}  // namespace cagefit::client

#endif  // CAGEFIT_CLIENT_COMMANDS_FOLDER_FOLLOWER_H_
