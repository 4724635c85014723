// Whole files in memory, and folders for them.
#ifndef CAGEFIT_CLIENT_IO_FILE_BYTES_H_
#define CAGEFIT_CLIENT_IO_FILE_BYTES_H_

#include <cstdint>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace cagefit::client {

// NOT_FOUND, INVALID_ARGUMENT for a folder, RESOURCE_EXHAUSTED above `max_bytes`,
// FAILED_PRECONDITION when it cannot be read; the message starts with the path.
absl::StatusOr<std::string> ReadFileBytes(const std::string& path, int64_t max_bytes);

// Whole or not at all: written beside and renamed. FAILED_PRECONDITION, the message starting with
// the path.
absl::Status WriteFileBytes(const std::string& path, absl::string_view bytes);

// With the folders above it; one that is there is fine. FAILED_PRECONDITION, as above.
absl::Status MakeFolder(const std::string& path);

}  // namespace cagefit::client

#endif  // CAGEFIT_CLIENT_IO_FILE_BYTES_H_
