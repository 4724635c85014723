// CRC-32C (Castagnoli), as RFC 3720 has it.
#ifndef CAGEFIT_CORE_CODEC_CRC32C_H_
#define CAGEFIT_CORE_CODEC_CRC32C_H_

#include <cstdint>

#include "absl/strings/string_view.h"

namespace cagefit {

// 0xE3069283 for "123456789".
uint32_t Crc32c(absl::string_view bytes);

}  // namespace cagefit

#endif  // CAGEFIT_CORE_CODEC_CRC32C_H_
