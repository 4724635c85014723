#include "server/session/frame_masks.h"

#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"
#include "core/base/status.h"
#include "core/codec/png.h"
#include "server/session/error_detail.h"

namespace cagefit::server {
namespace {

// Of a pixel: the image that is kept, and the samples that a PNG is read to (core/codec/png.h).
constexpr int64_t kKeptBytes = sizeof(float), kReadBytes = 8;

std::string Quoted(absl::string_view name) { return absl::StrCat("\"", name, "\""); }

std::string Element(const std::string& field, size_t k) { return absl::StrCat(field, "[", k, "]"); }

absl::Status UnknownCamera(const std::string& field, const std::string& name,
                           const std::vector<Camera>& cameras) {
  constexpr size_t kMostNames = 8;
  std::string known = cameras.empty() ? "the session has no cameras" : "the session's cameras are ";
  for (size_t k = 0; k < std::min(cameras.size(), kMostNames); ++k) {
    absl::StrAppend(&known, k > 0 ? ", " : "", Quoted(cameras[k].name));
  }
  if (cameras.size() > kMostNames) absl::StrAppend(&known, ", ...");
  return InvalidField(absl::StrCat(field, ".camera"), Quoted(name), known);
}

absl::StatusOr<Image> DecodeMask(const std::string& field, absl::string_view png,
                                 const Camera& camera) {
  // Not decoded where it is larger than its camera, so what decoding takes is known beforehand.
  const PngLimits limits = {camera.width, camera.height,
                            static_cast<int64_t>(camera.width) * camera.height};
  auto image = DecodePng(png, limits);
  if (!image.ok()) {
    return WithDetail(absl::InvalidArgumentError(absl::StrCat(
                          field, " of camera ", Quoted(camera.name), ", ", camera.width, " x ",
                          camera.height, " pixels: ", image.status().message())),
                      {"BAD_MASK", field, camera.name, ""});
  }
  if (image->width == camera.width && image->height == camera.height) return image;
  return InvalidField(
      field, absl::StrCat(image->width, " x ", image->height, " pixels"),
      absl::StrCat("camera ", Quoted(camera.name), " has ", camera.width, " x ", camera.height));
}

}  // namespace

absl::StatusOr<uint64_t> MaskBytes(const std::string& field, const std::vector<StatedMask>& masks,
                                   uint64_t total_bytes) {
  uint64_t sum = 0;
  for (size_t k = 0; k < masks.size(); ++k) {
    const uint64_t bytes = masks[k].png_bytes;
    if (bytes == 0) {
      return InvalidField(absl::StrCat(Element(field, k), ".png_bytes"), "0",
                          "the mask of a camera that saw nothing is left out");
    }
    if (bytes > total_bytes - sum) {
      return InvalidField(
          absl::StrCat(Element(field, k), ".png_bytes"), absl::StrCat(bytes),
          absl::StrCat("of the frame's ", total_bytes, " bytes ", total_bytes - sum, " are left"));
    }
    sum += bytes;
  }
  return sum;
}

int64_t DecodedMaskBytes(const std::vector<StatedMask>& masks, const std::vector<Camera>& cameras) {
  int64_t kept = 0, most = 0;
  for (const Camera& camera : cameras) {
    const bool has_mask = std::any_of(masks.begin(), masks.end(), [&camera](const StatedMask& m) {
      return m.camera == camera.name;
    });
    if (!has_mask) continue;
    const int64_t pixels = static_cast<int64_t>(camera.width) * camera.height;
    kept += pixels;
    most = std::max(most, pixels);
  }
  return kKeptBytes * kept + kReadBytes * most;
}

absl::StatusOr<std::vector<Image>> DecodeMasks(const std::string& field, absl::string_view bytes,
                                               const std::vector<StatedMask>& masks,
                                               const std::vector<Camera>& cameras) {
  std::vector<Image> images(cameras.size());
  for (size_t k = 0; k < masks.size(); ++k) {
    const auto camera = std::find_if(cameras.begin(), cameras.end(),
                                     [&](const Camera& c) { return c.name == masks[k].camera; });
    if (camera == cameras.end()) {
      return UnknownCamera(Element(field, k), masks[k].camera, cameras);
    }
    Image& image = images[camera - cameras.begin()];
    if (!image.empty()) {
      return InvalidField(absl::StrCat(Element(field, k), ".camera"), Quoted(masks[k].camera),
                          "it has a mask in this frame already");
    }
    ASSIGN_OR_RETURN(image,
                     DecodeMask(Element(field, k), bytes.substr(0, masks[k].png_bytes), *camera));
    bytes.remove_prefix(masks[k].png_bytes);
  }
  return images;
}

}  // namespace cagefit::server
