// SHA-256 of a frame's bytes: tells a repeated frame from another one with the same number.
#ifndef CAGEFIT_SERVER_SESSION_DIGEST_H_
#define CAGEFIT_SERVER_SESSION_DIGEST_H_

#include <array>
#include <cstdint>
#include <string>

#include "absl/strings/string_view.h"

namespace cagefit::server {

using Digest = std::array<uint8_t, 32>;

Digest Sha256(absl::string_view bytes);

// 128 random bits as 32 hexadecimal digits: an identifier that cannot be guessed.
std::string RandomId();

}  // namespace cagefit::server

#endif  // CAGEFIT_SERVER_SESSION_DIGEST_H_
