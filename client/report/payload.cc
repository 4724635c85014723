#include "client/report/payload.h"

#include <zlib.h>

#include <cassert>
#include <utility>

#include "absl/strings/escaping.h"

namespace cagefit::client {
namespace {

std::string Deflate(const std::string& bytes) {
  uLongf size = compressBound(bytes.size());
  std::string deflated(size, '\0');
  const int result =
      compress2(reinterpret_cast<Bytef*>(deflated.data()), &size,
                reinterpret_cast<const Bytef*>(bytes.data()), bytes.size(), Z_BEST_COMPRESSION);
  assert(result == Z_OK);  // there is room for the worst case
  static_cast<void>(result);
  deflated.resize(size);
  return deflated;
}

}  // namespace

void Payload::Add(const std::string& name, int width, size_t stride,
                  const std::vector<uint32_t>& values) {
  arrays_.push_back(
      {{"name", name}, {"width", width}, {"count", values.size()}, {"stride", stride}});
  for (int plane = 0; plane < width; ++plane) {
    for (size_t i = 0; i < values.size(); ++i) {
      const uint32_t before = stride > 0 && i >= stride ? values[i - stride] : 0;
      planes_.push_back(static_cast<char>((values[i] - before) >> (8 * plane)));
    }
  }
}

std::string Payload::Encode(nlohmann::ordered_json header) const {
  header["arrays"] = arrays_;
  const std::string text =
      header.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
  std::string bytes;
  for (int byte = 0; byte < 4; ++byte) {
    bytes.push_back(static_cast<char>(text.size() >> (8 * byte)));
  }
  return absl::Base64Escape(Deflate(bytes + text + planes_));
}

}  // namespace cagefit::client
