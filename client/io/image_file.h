// Masks and rendered images in files.
#ifndef CAGEFIT_CLIENT_IO_IMAGE_FILE_H_
#define CAGEFIT_CLIENT_IO_IMAGE_FILE_H_

#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/codec/png.h"
#include "core/image/image.h"

namespace cagefit::client {

// A mask from a PNG file of any kind, 1 channel of 0 to 1 as DecodePng gives it. NOT_FOUND,
// INVALID_ARGUMENT, RESOURCE_EXHAUSTED or UNAVAILABLE; the message starts with the path.
absl::StatusOr<Image> ReadMask(const std::string& path, const PngLimits& limits = {});

// Writers take images of 1 or 3 channels and write whole files or none. INVALID_ARGUMENT or
// UNAVAILABLE; the message starts with the path.

// PNG of 8 or 16 bits; values are clamped to 0 to 1.
absl::Status WritePng(const std::string& path, const Image& image, int bits);

// PFM, a portable float map: the values to the bit, little-endian, the bottom row first.
absl::Status WritePfm(const std::string& path, const Image& image);

}  // namespace cagefit::client

#endif  // CAGEFIT_CLIENT_IO_IMAGE_FILE_H_
