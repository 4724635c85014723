#include "client/commands/mask_files.h"

#include <algorithm>
#include <filesystem>
#include <map>
#include <utility>

#include "absl/strings/str_cat.h"
#include "client/io/file_bytes.h"
#include "core/base/status.h"

namespace cagefit::client {
namespace {

namespace fs = std::filesystem;

constexpr int64_t kMaxMaskBytes = int64_t{1} << 30;

// A name with a slash, as COLMAP's may have, is a folder in a folder.
std::string TopFolder(const std::string& camera) { return camera.substr(0, camera.find('/')); }

absl::Status CheckFolder(const std::string& folder, const std::vector<std::string>& cameras) {
  if (!fs::is_directory(folder)) {
    return absl::NotFoundError(absl::StrCat(folder, ": there is no such folder"));
  }
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
    const std::string name = entry.path().filename().string();
    if (!entry.is_directory() || name[0] == '.') continue;
    const bool known = std::any_of(cameras.begin(), cameras.end(), [&name](const auto& camera) {
      return TopFolder(camera) == name;
    });
    if (known) continue;
    return absl::InvalidArgumentError(
        absl::StrCat(entry.path().string(), ": no camera is named \"", name, "\""));
  }
  if (!error) return absl::OkStatus();
  return absl::FailedPreconditionError(absl::StrCat(folder, ": cannot be read: ", error.message()));
}

}  // namespace

absl::StatusOr<std::vector<std::vector<MaskFile>>> ListMasks(
    const std::string& folder, const std::vector<std::string>& cameras,
    const std::vector<std::string>& frames) {
  RETURN_IF_ERROR(CheckFolder(folder, cameras));
  std::vector<std::vector<MaskFile>> masks(frames.size());
  std::map<std::string, std::string> frame_of_stem;
  bool found = false;
  for (size_t k = 0; k < frames.size(); ++k) {
    const std::string stem = fs::path(frames[k]).stem().string();
    const auto [other, is_new] = frame_of_stem.emplace(stem, frames[k]);
    if (!is_new) {
      return absl::InvalidArgumentError(absl::StrCat(frames[k], ": has the name of ", other->second,
                                                     ", so its masks cannot be told apart"));
    }
    for (const std::string& camera : cameras) {
      std::string path = absl::StrCat(folder, "/", camera, "/", stem, ".png");
      if (fs::exists(path)) masks[k].push_back({camera, std::move(path)});
    }
    found |= !masks[k].empty();
  }
  if (found || frames.empty()) return masks;
  return absl::InvalidArgumentError(
      absl::StrCat(folder, ": holds no mask of these frames; looked for ", folder, "/CAMERA/",
                   fs::path(frames[0]).stem().string(), ".png and the like"));
}

absl::StatusOr<std::vector<OutgoingMask>> ReadMasks(const std::vector<MaskFile>& files) {
  std::vector<OutgoingMask> masks;
  for (const MaskFile& file : files) {
    ASSIGN_OR_RETURN(std::string png, ReadFileBytes(file.path, kMaxMaskBytes));
    masks.push_back({file.camera, std::move(png)});
  }
  return masks;
}

}  // namespace cagefit::client
