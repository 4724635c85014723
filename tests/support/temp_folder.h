// A folder of this process alone: ctest runs the tests of one program at the same time.
#ifndef CAGEFIT_TESTS_SUPPORT_TEMP_FOLDER_H_
#define CAGEFIT_TESTS_SUPPORT_TEMP_FOLDER_H_

#include <string>

#include "core/base/private_folder.h"

namespace cagefit::testing {

// Ends with a slash; made by the first call, removed with all in it when the process ends.
inline const std::string& TempFolder() {
  static const PrivateFolder folder = PrivateFolder::Create().value();
  static const std::string path = folder.path() + "/";
  return path;
}

}  // namespace cagefit::testing

#endif  // CAGEFIT_TESTS_SUPPORT_TEMP_FOLDER_H_
