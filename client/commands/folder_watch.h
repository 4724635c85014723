// Which files of a folder that is being written to are complete, and in which order they come.
#ifndef CAGEFIT_CLIENT_COMMANDS_FOLDER_WATCH_H_
#define CAGEFIT_CLIENT_COMMANDS_FOLDER_WATCH_H_

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "absl/time/time.h"
#include "client/commands/input_files.h"

namespace cagefit::client {

struct FileState {
  std::string name;
  int64_t bytes = 0;
  absl::Time modified;
};

// A file is complete once its size and time have not changed for the settling time, or at once when
// it was renamed to its name. An empty file is complete only when a later one is: its writer has
// just begun. Files come in natural order of their names, so one that is being written holds those
// behind it up. One whose name comes before that of a file that was taken is too late.
class FolderWatch {
 public:
  explicit FolderWatch(absl::Duration settle) : settle_(settle) {}

  // One look at the folder: all of its files.
  void Look(const std::vector<FileState>& files, absl::Time now);
  // A file was renamed to `name`; the next look sees it.
  void Renamed(const std::string& name) { renamed_.insert(name); }

  // The next complete file, once.
  std::optional<std::string> Take();
  // Files that were too late, each once.
  std::vector<std::string> TakeLate();

  // When a file was new or changed last; InfinitePast before.
  absl::Time last_change() const { return last_change_; }

 private:
  struct NaturalOrder {
    bool operator()(const std::string& a, const std::string& b) const { return NaturalLess(a, b); }
  };
  struct Waiting {
    FileState state;
    absl::Time unchanged_since;
    bool complete = false;
  };

  void See(const FileState& file, absl::Time now);

  const absl::Duration settle_;
  std::map<std::string, Waiting, NaturalOrder> waiting_;
  std::set<std::string> renamed_;
  std::set<std::string> done_;  // taken, or too late
  std::string last_taken_;
  std::vector<std::string> late_;
  absl::Time last_change_ = absl::InfinitePast();
};

}  // namespace cagefit::client

#endif  // CAGEFIT_CLIENT_COMMANDS_FOLDER_WATCH_H_
