#include "client/io/image_file.h"

#include <cstring>

#include "absl/strings/str_cat.h"
#include "client/io/file_bytes.h"
#include "core/base/status.h"

namespace cagefit::client {
namespace {

constexpr int64_t kMostFileBytes = int64_t{1} << 30;

absl::Status Prefixed(const std::string& path, const absl::Status& status) {
  return absl::Status(status.code(), absl::StrCat(path, ": ", status.message()));
}

}  // namespace

absl::StatusOr<Image> ReadMask(const std::string& path, const PngLimits& limits) {
  ASSIGN_OR_RETURN(const std::string bytes, ReadFileBytes(path, kMostFileBytes));
  auto mask = DecodePng(bytes, limits);
  if (!mask.ok()) return Prefixed(path, mask.status());
  return mask;
}

absl::Status WritePng(const std::string& path, const Image& image, int bits) {
  const auto bytes = EncodePng(image, bits);
  if (!bytes.ok()) return Prefixed(path, bytes.status());
  return WriteFileBytes(path, *bytes);
}

absl::Status WritePfm(const std::string& path, const Image& image) {
  if (image.empty() || (image.channels != 1 && image.channels != 3)) {
    return absl::InvalidArgumentError(
        absl::StrCat(path, ": the image is ", image.width, " x ", image.height, " with ",
                     image.channels, " channels; expected pixels, and 1 or 3 channels"));
  }
  // The sign of the scale, not its size, says little-endian.
  std::string bytes = absl::StrCat(image.channels == 1 ? "Pf" : "PF", "\n", image.width, " ",
                                   image.height, "\n-1.0\n");
  const size_t head = bytes.size(), row_floats = static_cast<size_t>(image.width) * image.channels;
  bytes.resize(head + row_floats * image.height * sizeof(float));
  char* out = bytes.data() + head;
  for (int y = image.height - 1; y >= 0; --y, out += row_floats * sizeof(float)) {
    std::memcpy(out, image.at(0, y), row_floats * sizeof(float));
  }
  return WriteFileBytes(path, bytes);
}

}  // namespace cagefit::client
