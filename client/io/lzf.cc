#include "client/io/lzf.h"

#include <cstdint>

#include "absl/strings/str_cat.h"

namespace cagefit::client {
namespace {

constexpr size_t kLiteralControls = 32;
constexpr size_t kLongLength = 7;
// Three bytes stand for at most this many.
constexpr size_t kMostExpansion = 264;

}  // namespace

absl::StatusOr<std::string> DecompressLzf(absl::string_view compressed, size_t size) {
  const auto broken = [](absl::string_view what) {
    return absl::InvalidArgumentError(absl::StrCat("the compressed data are broken: ", what));
  };
  if (size / kMostExpansion > compressed.size()) return broken("too few for what they claim");
  std::string out;
  out.reserve(size);
  size_t at = 0;
  const auto byte = [&] { return static_cast<size_t>(static_cast<uint8_t>(compressed[at++])); };
  while (at < compressed.size()) {
    const size_t control = byte();
    if (control < kLiteralControls) {
      const size_t length = control + 1;
      if (length > compressed.size() - at) return broken("they end early");
      out.append(compressed.data() + at, length);
      at += length;
    } else {
      size_t length = control / kLiteralControls;
      if (compressed.size() - at < (length == kLongLength ? 2 : 1)) return broken("they end early");
      if (length == kLongLength) length += byte();
      length += 2;
      const size_t back = 256 * (control % kLiteralControls) + byte() + 1;
      if (back > out.size()) return broken("they refer to what was never there");
      // Byte by byte: the piece may overlap what it makes.
      for (size_t k = 0; k < length; ++k) out.push_back(out[out.size() - back]);
    }
    if (out.size() > size) return broken("they hold more than they claim");
  }
  if (out.size() != size) return broken("they hold less than they claim");
  return out;
}

}  // namespace cagefit::client
