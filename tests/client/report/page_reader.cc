#include "tests/client/report/page_reader.h"

#include <zlib.h>

#include <stdexcept>

namespace cagefit::testing {
namespace {

std::string DecodeBase64(const std::string& text) {
  const std::string alphabet = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string bytes;
  uint32_t bits = 0;
  int held = 0;
  for (const char c : text.substr(0, text.find('='))) {
    const size_t value = alphabet.find(c);
    if (value == std::string::npos) throw std::runtime_error("no base64");
    bits = bits << 6 | static_cast<uint32_t>(value);
    held += 6;
    if (held < 8) continue;
    held -= 8;
    bytes.push_back(static_cast<char>(bits >> held));
  }
  return bytes;
}

std::string Inflate(const std::string& deflated) {
  std::string bytes;
  char step[1 << 16];
  z_stream stream = {};
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(deflated.data()));
  stream.avail_in = static_cast<uInt>(deflated.size());
  inflateInit(&stream);
  int result = Z_OK;
  while (result == Z_OK) {
    stream.next_out = reinterpret_cast<Bytef*>(step);
    stream.avail_out = sizeof(step);
    result = inflate(&stream, Z_NO_FLUSH);
    bytes.append(step, sizeof(step) - stream.avail_out);
  }
  inflateEnd(&stream);
  if (result != Z_STREAM_END) throw std::runtime_error("no whole zlib stream");
  return bytes;
}

}  // namespace

PageData ReadPayload(const std::string& text) {
  const std::string bytes = Inflate(DecodeBase64(text));
  const auto byte = [&](size_t at) -> uint32_t { return static_cast<unsigned char>(bytes.at(at)); };
  const size_t length = byte(0) | byte(1) << 8 | byte(2) << 16 | byte(3) << 24;
  PageData data;
  data.header = nlohmann::json::parse(bytes.substr(4, length));
  size_t begin = 4 + length;
  for (const auto& array : data.header.at("arrays")) {
    const size_t width = array.at("width"), count = array.at("count"), stride = array.at("stride");
    std::vector<uint32_t>& values = data.arrays[array.at("name")];
    for (size_t i = 0; i < count; ++i) {
      uint32_t value = 0;
      for (size_t plane = 0; plane < width; ++plane) {
        value |= byte(begin + plane * count + i) << (8 * plane);
      }
      if (stride > 0 && i >= stride) value += values[i - stride];
      values.push_back(width == 4 ? value : value & ((1u << (8 * width)) - 1));
    }
    begin += width * count;
  }
  if (begin != bytes.size()) throw std::runtime_error("bytes behind the last array");
  return data;
}

ReportPage SplitPage(const std::string& html) {
  const std::string open = "<script id=\"data\" type=\"text/plain\">";
  const size_t begin = html.find(open) + open.size(), end = html.find("</script>", begin);
  return {html.substr(begin, end - begin), html.substr(0, begin) + html.substr(end)};
}

}  // namespace cagefit::testing
