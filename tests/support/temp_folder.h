// A folder of this process alone: ctest runs the tests of one program at the same time.
#ifndef CAGEFIT_TESTS_SUPPORT_TEMP_FOLDER_H_
#define CAGEFIT_TESTS_SUPPORT_TEMP_FOLDER_H_

#include <unistd.h>

#include <filesystem>
#include <string>
#include <system_error>

namespace cagefit::testing {

// Ends with a slash; made by the first call, removed with all in it when the process ends.
inline const std::string& TempFolder() {
  struct Folder {
    Folder() { std::filesystem::create_directories(path); }
    ~Folder() {
      std::error_code ignored;
      if (getpid() == owner) std::filesystem::remove_all(path, ignored);  // no child's
    }
    const pid_t owner = getpid();
    const std::string path = "/tmp/cagefit_test." + std::to_string(owner) + "/";
  };
  static const Folder folder;
  return folder.path;
}

}  // namespace cagefit::testing

#endif  // CAGEFIT_TESTS_SUPPORT_TEMP_FOLDER_H_
