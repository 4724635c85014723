// A folder that only this user may enter, removed with everything in it.
#ifndef CAGEFIT_CORE_BASE_PRIVATE_FOLDER_H_
#define CAGEFIT_CORE_BASE_PRIVATE_FOLDER_H_

#include <string>

#include "absl/status/statusor.h"

namespace cagefit {

class PrivateFolder {
 public:
  // In $TMPDIR or /tmp, mode 0700. INTERNAL when it cannot be made.
  static absl::StatusOr<PrivateFolder> Create();
  ~PrivateFolder();
  PrivateFolder(PrivateFolder&& other) noexcept;
  PrivateFolder& operator=(PrivateFolder&&) = delete;

  const std::string& path() const { return path_; }

 private:
  explicit PrivateFolder(std::string path) : path_(std::move(path)) {}
  std::string path_;  // empty once moved from
};

}  // namespace cagefit

#endif  // CAGEFIT_CORE_BASE_PRIVATE_FOLDER_H_
