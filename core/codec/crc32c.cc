#include "core/codec/crc32c.h"

#include <isa-l/crc.h>

#include <algorithm>

namespace cagefit {

uint32_t Crc32c(absl::string_view bytes) {
  // The library's length is an int, so long arrays go in pieces.
  constexpr size_t kPiece = size_t{1} << 30;
  uint32_t crc = ~uint32_t{0};
  while (!bytes.empty()) {
    const size_t piece = std::min(bytes.size(), kPiece);
    crc = crc32_iscsi(
        reinterpret_cast<unsigned char*>(const_cast<char*>(bytes.data())),  // which it only reads
        static_cast<int>(piece), crc);
    bytes.remove_prefix(piece);
  }
  return ~crc;
}

}  // namespace cagefit
