#include "tests/core/codec/png_samples.h"

namespace cagefit::testing {
namespace {

constexpr char kSignature[] = "\x89PNG\r\n\x1a\n";

std::string Word(uint32_t value) {
  std::string bytes;
  for (int shift = 24; shift >= 0; shift -= 8) bytes.push_back(static_cast<char>(value >> shift));
  return bytes;
}

uint32_t Crc(const std::string& bytes) {
  uint32_t crc = ~0u;
  for (const char byte : bytes) {
    crc ^= static_cast<uint8_t>(byte);
    for (int k = 0; k < 8; ++k) crc = (crc & 1) != 0 ? 0xedb88320u ^ (crc >> 1) : crc >> 1;
  }
  return ~crc;
}

std::string Chunk(const std::string& type, const std::string& data) {
  return Word(static_cast<uint32_t>(data.size())) + type + data + Word(Crc(type + data));
}

// A zlib stream of one stored block.
std::string Stored(const std::string& data) {
  const auto size = static_cast<uint16_t>(data.size());
  std::string bytes("\x78\x01\x01", 3);
  for (const int half : {size & 255, size >> 8, ~size & 255, (~size >> 8) & 255}) {
    bytes.push_back(static_cast<char>(half));
  }
  uint32_t a = 1, b = 0;
  for (const char byte : data) {
    a = (a + static_cast<uint8_t>(byte)) % 65521;
    b = (b + a) % 65521;
  }
  return bytes + data + Word(b << 16 | a);
}

int Channels(PngColor color) {
  return color == kRgb ? 3 : color == kRgba ? 4 : color == kGrayAlpha ? 2 : 1;
}

// Every `dx`-th pixel from x0 and every `dy`-th row from y0, each row behind filter byte 0.
std::string Pass(const PngSample& png, uint32_t x0, uint32_t y0, uint32_t dx, uint32_t dy) {
  std::string bytes;
  if (x0 >= png.width) return bytes;
  for (uint32_t y = y0; y < png.height; y += dy) {
    bytes.push_back('\0');
    int filled = 8;  // bits of the last byte
    for (uint32_t x = x0; x < png.width; x += dx) {
      for (int c = 0; c < Channels(png.color); ++c) {
        const int value = png.samples[(y * png.width + x) * Channels(png.color) + c];
        if (png.bits == 16) bytes.push_back(static_cast<char>(value >> 8));
        if (png.bits >= 8) {
          bytes.push_back(static_cast<char>(value & 255));
          continue;
        }
        if (filled == 8) bytes.push_back('\0');
        filled = filled % 8 + png.bits;
        bytes.back() = static_cast<char>(bytes.back() | value << (8 - filled));
      }
    }
  }
  return bytes;
}

std::string Header(const PngSample& png) {
  std::string data = Word(png.width) + Word(png.height);
  for (const int byte : {png.bits, static_cast<int>(png.color), 0, 0, png.interlaced ? 1 : 0}) {
    data.push_back(static_cast<char>(byte));
  }
  return kSignature + Chunk("IHDR", data);
}

}  // namespace

std::string PngBytes(const PngSample& png) {
  std::string bytes = Header(png);
  if (!png.palette.empty()) bytes += Chunk("PLTE", png.palette);
  if (!png.transparency.empty()) bytes += Chunk("tRNS", png.transparency);
  if (png.interlaced) {
    bytes +=
        Chunk("IDAT", Stored(Pass(png, 0, 0, 8, 8) + Pass(png, 4, 0, 8, 8) + Pass(png, 0, 4, 4, 8) +
                             Pass(png, 2, 0, 4, 4) + Pass(png, 0, 2, 2, 4) + Pass(png, 1, 0, 2, 2) +
                             Pass(png, 0, 1, 1, 2)));
  } else {
    bytes += Chunk("IDAT", Stored(Pass(png, 0, 0, 1, 1)));
  }
  return bytes + Chunk("IEND", "");
}

std::string PngHeader(uint32_t width, uint32_t height) {
  PngSample png;
  png.width = width;
  png.height = height;
  return Header(png) + Chunk("IDAT", "");
}

std::string WithGoodChecksums(std::string bytes) {
  for (size_t at = 8; at + 12 <= bytes.size();) {
    size_t size = 0;
    for (int k = 0; k < 4; ++k) size = size << 8 | static_cast<uint8_t>(bytes[at + k]);
    if (size > bytes.size() - at - 12) break;
    bytes.replace(at + 8 + size, 4, Word(Crc(bytes.substr(at + 4, 4 + size))));
    at += 12 + size;
  }
  return bytes;
}

}  // namespace cagefit::testing
