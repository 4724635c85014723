// Tells when a child process has begun and when nothing of it is left.
#ifndef CAGEFIT_TESTS_SERVER_SESSION_LIFE_LINE_H_
#define CAGEFIT_TESTS_SERVER_SESSION_LIFE_LINE_H_

#include <fcntl.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/stat.h>
#include <unistd.h>

#include <string>

#include "core/base/private_folder.h"

namespace cagefit::server::testing {

// A named pipe whose writers are the child's processes: its end tells that all of them are gone.
class LifeLine {
 public:
  LifeLine() : folder_(PrivateFolder::Create().value()), path_(folder_.path() + "/pipe") {
    EXPECT_EQ(mkfifo(path_.c_str(), 0600), 0);
    fd_ = open(path_.c_str(), O_RDONLY | O_NONBLOCK);
    EXPECT_GE(fd_, 0);
  }
  ~LifeLine() { close(fd_); }

  const std::string& path() const { return path_; }
  // True once a byte was written, which is taken.
  bool Started() {
    char byte;
    return read(fd_, &byte, 1) == 1;
  }
  bool WaitForStart() {
    pollfd ready = {fd_, POLLIN, 0};
    return poll(&ready, 1, 30'000) == 1 && Started();
  }
  bool AllWritersEnd() {
    pollfd ready = {fd_, 0, 0};
    return poll(&ready, 1, 10'000) == 1 && (ready.revents & POLLHUP) != 0;
  }

 private:
  PrivateFolder folder_;
  std::string path_;
  int fd_ = -1;
};

}  // namespace cagefit::server::testing

#endif  // CAGEFIT_TESTS_SERVER_SESSION_LIFE_LINE_H_
