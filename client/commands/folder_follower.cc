#include "client/commands/folder_follower.h"

#include <poll.h>
#include <sys/eventfd.h>
#include <sys/inotify.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <iostream>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "client/io/geometry_file.h"
#include "core/base/status.h"

namespace cagefit::client {
namespace {

namespace fs = std::filesystem;

// Between looks at the folder: network folders tell nobody of what others write.
constexpr absl::Duration kLongestTick = absl::Milliseconds(100);

void LeaveOut(const std::string& path, absl::string_view why) {
  std::cerr << "cagefit: " << path << " is left out: " << why << "\n";
}

}  // namespace

absl::StatusOr<std::unique_ptr<FolderFollower>> FolderFollower::Open(std::string folder,
                                                                     const FollowOptions& options) {
  std::unique_ptr<FolderFollower> follower(new FolderFollower(std::move(folder), options));
  RETURN_IF_ERROR(follower->Look());
  std::cerr << "cagefit: follows " << follower->folder_ << " until Ctrl-C"
            << (options.idle < absl::InfiniteDuration()
                    ? absl::StrCat(", or until it is idle for ", absl::FormatDuration(options.idle))
                    : "")
            << "\n";
  return follower;
}

FolderFollower::FolderFollower(std::string folder, const FollowOptions& options)
    : folder_(std::move(folder)),
      options_(options),
      notices_(inotify_init1(IN_NONBLOCK | IN_CLOEXEC)),
      stop_(eventfd(0, EFD_CLOEXEC)),
      begun_(absl::Now()),
      watch_(options.settle) {
  if (notices_ >= 0) inotify_add_watch(notices_, folder_.c_str(), IN_MOVED_TO);
}

FolderFollower::~FolderFollower() {
  if (notices_ >= 0) close(notices_);
  close(stop_);
}

void FolderFollower::Stop() {
  stopped_ = true;
  eventfd_write(stop_, 1);
}

std::optional<std::string> FolderFollower::Next() {
  // A file that is still settling is not forgotten.
  const absl::Duration idle = std::max(options_.idle, options_.settle + 2 * kLongestTick);
  while (!stopped_) {
    const absl::Status looked = Look();
    if (!looked.ok()) {
      std::cerr << "cagefit: " << looked.message() << "\n";
      return std::nullopt;
    }
    while (std::optional<std::string> name = watch_.Take()) {
      const std::string path = absl::StrCat(folder_, "/", *name);
      if (format_.empty()) format_ = FileExtension(path);
      if (FileExtension(path) == format_) return path;
      LeaveOut(path, absl::StrCat("the first file of this sequence is ", format_));
    }
    if (absl::Now() - std::max(watch_.last_change(), begun_) >= idle) return std::nullopt;
    Wait();
  }
  return std::nullopt;
}

absl::Status FolderFollower::Look() {
  ReadRenames();
  std::vector<FileState> files;
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder_, error)) {
    const std::string path = entry.path().string(), name = entry.path().filename().string();
    struct stat info;
    if (name[0] == '.' || !IsGeometryFile(path) || stat(path.c_str(), &info) != 0) continue;
    if (S_ISREG(info.st_mode)) {
      files.push_back({name, info.st_size, absl::TimeFromTimespec(info.st_mtim)});
    }
  }
  if (error) {
    return absl::FailedPreconditionError(
        absl::StrCat(folder_, ": cannot be read: ", error.message()));
  }
  watch_.Look(files, absl::Now());
  for (const std::string& name : watch_.TakeLate()) {
    LeaveOut(absl::StrCat(folder_, "/", name), "it came after later ones were taken");
  }
  return absl::OkStatus();
}

void FolderFollower::ReadRenames() {
  alignas(inotify_event) char buffer[4096];
  while (notices_ >= 0) {
    const ssize_t size = read(notices_, buffer, sizeof(buffer));
    if (size <= 0) return;
    for (const char* at = buffer; at < buffer + size;) {
      const auto* event = reinterpret_cast<const inotify_event*>(at);
      if (event->len > 0) watch_.Renamed(event->name);
      at += sizeof(inotify_event) + event->len;
    }
  }
}

void FolderFollower::Wait() {
  pollfd events[] = {{stop_, POLLIN, 0}, {notices_, POLLIN, 0}};
  const absl::Duration tick =
      std::min(kLongestTick, std::max(options_.settle / 4, absl::Milliseconds(1)));
  poll(events, 2, static_cast<int>(absl::ToInt64Milliseconds(tick)));
}

}  // namespace cagefit::client
