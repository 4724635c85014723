#include "client/io/camera_file.h"

#include <filesystem>

#include "absl/strings/str_cat.h"
#include "client/io/camera_readers.h"
#include "client/io/file_bytes.h"
#include "core/base/status.h"

namespace cagefit::client {
namespace {

constexpr int64_t kMostJsonBytes = int64_t{16} << 20;   // 40,000 cameras
constexpr int64_t kMostColmapBytes = int64_t{2} << 30;  // images.txt lists every feature

absl::Status Prefixed(const std::string& path, const absl::Status& status) {
  return absl::Status(status.code(), absl::StrCat(path, ": ", status.message()));
}

bool Exists(const std::string& path) {
  std::error_code error;
  return std::filesystem::exists(path, error);
}

absl::StatusOr<std::vector<Camera>> ReadColmap(const std::string& folder) {
  const std::string base = absl::StrCat(folder, folder.back() == '/' ? "" : "/");
  const std::string cameras_path = base + "cameras.txt", images_path = base + "images.txt";
  if (!Exists(cameras_path) && Exists(base + "cameras.bin")) {
    return absl::InvalidArgumentError(
        absl::StrCat(folder,
                     ": holds COLMAP's binary model; expected the text one, as written by "
                     "colmap model_converter --output_type TXT"));
  }
  ASSIGN_OR_RETURN(const std::string cameras_text, ReadFileBytes(cameras_path, kMostColmapBytes));
  const auto intrinsics = ReadColmapCameras(cameras_text);
  if (!intrinsics.ok()) return Prefixed(cameras_path, intrinsics.status());
  ASSIGN_OR_RETURN(const std::string images_text, ReadFileBytes(images_path, kMostColmapBytes));
  auto cameras = ReadColmapImages(images_text, *intrinsics);
  if (!cameras.ok()) return Prefixed(images_path, cameras.status());
  return cameras;
}

}  // namespace

absl::StatusOr<std::vector<Camera>> ReadCameras(const std::string& path) {
  std::error_code error;
  if (std::filesystem::is_directory(path, error)) return ReadColmap(path);
  ASSIGN_OR_RETURN(const std::string bytes, ReadFileBytes(path, kMostJsonBytes));
  auto cameras = ReadCamerasJson(bytes);
  if (!cameras.ok()) return Prefixed(path, cameras.status());
  return cameras;
}

absl::Status WriteCameras(const std::string& path, const std::vector<Camera>& cameras) {
  const auto text = CamerasToJson(cameras);
  if (!text.ok()) return Prefixed(path, text.status());
  return WriteFileBytes(path, *text);
}

}  // namespace cagefit::client
