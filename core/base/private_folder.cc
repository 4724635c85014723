#include "core/base/private_folder.h"

#include <stdlib.h>
#include <string.h>

#include <cerrno>
#include <filesystem>
#include <utility>

#include "absl/strings/str_cat.h"

namespace cagefit {

absl::StatusOr<PrivateFolder> PrivateFolder::Create() {
  const char* parent = getenv("TMPDIR");
  std::string path =
      absl::StrCat(parent != nullptr && *parent != '\0' ? parent : "/tmp", "/cagefit-XXXXXX");
  if (mkdtemp(path.data()) == nullptr) {
    return absl::InternalError(absl::StrCat(path, ": ", strerror(errno)));
  }
  return PrivateFolder(std::move(path));
}

PrivateFolder::PrivateFolder(PrivateFolder&& other) noexcept
    : path_(std::exchange(other.path_, std::string())) {}

PrivateFolder::~PrivateFolder() {
  std::error_code ignored;  // nothing can be done about a folder that does not go
  if (!path_.empty()) std::filesystem::remove_all(path_, ignored);
}

}  // namespace cagefit
