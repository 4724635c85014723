#include "client/commands/folder_watch.h"

#include <algorithm>
#include <utility>

namespace cagefit::client {

void FolderWatch::Look(const std::vector<FileState>& files, absl::Time now) {
  for (const FileState& file : files) {
    if (done_.count(file.name) > 0) continue;
    if (!last_taken_.empty() && NaturalLess(file.name, last_taken_)) {
      late_.push_back(file.name);
      done_.insert(file.name);
      continue;
    }
    See(file, now);
  }
  renamed_.clear();  // what was renamed away again is of no interest
  // An empty file was begun before a later one that is complete, and nothing came of it.
  bool later_is_complete = false;
  for (auto file = waiting_.rbegin(); file != waiting_.rend(); ++file) {
    if (file->second.state.bytes == 0) file->second.complete = later_is_complete;
    later_is_complete |= file->second.complete;
  }
}

void FolderWatch::See(const FileState& file, absl::Time now) {
  const auto [place, is_new] = waiting_.try_emplace(file.name);
  Waiting& waiting = place->second;
  if (is_new) {
    waiting.unchanged_since = std::min(now, file.modified);
    last_change_ = now;
  } else if (file.bytes != waiting.state.bytes || file.modified != waiting.state.modified) {
    waiting.unchanged_since = last_change_ = now;
  }
  waiting.state = file;
  waiting.complete = now - waiting.unchanged_since >= settle_ || renamed_.erase(file.name) > 0 ||
                     (waiting.complete && waiting.unchanged_since != now);
}

std::optional<std::string> FolderWatch::Take() {
  if (waiting_.empty() || !waiting_.begin()->second.complete) return std::nullopt;
  last_taken_ = waiting_.begin()->first;
  done_.insert(last_taken_);
  waiting_.erase(waiting_.begin());
  return last_taken_;
}

std::vector<std::string> FolderWatch::TakeLate() { return std::exchange(late_, {}); }

}  // namespace cagefit::client
