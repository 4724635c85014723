// LZF, the compression inside PCD files. Internal to client/io.
#ifndef CAGEFIT_CLIENT_IO_LZF_H_
#define CAGEFIT_CLIENT_IO_LZF_H_

#include <string>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace cagefit::client {

// The `size` bytes that `compressed` stands for; INVALID_ARGUMENT when it does not hold as many.
// A control byte c < 32 copies the next c + 1 bytes. Otherwise c / 32 + 2 bytes (7 / 32 stands for
// 9 plus the next byte) are repeated from 256 (c % 32) + next byte + 1 bytes before.
absl::StatusOr<std::string> DecompressLzf(absl::string_view compressed, size_t size);

}  // namespace cagefit::client

#endif  // CAGEFIT_CLIENT_IO_LZF_H_
