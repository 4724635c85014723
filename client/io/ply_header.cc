#include "client/io/ply_header.h"

#include <algorithm>
#include <cstring>
#include <limits>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "client/io/text_cursor.h"
#include "core/base/status.h"

namespace cagefit::client {
namespace {

struct TypeName {
  const char* name;
  ScalarType type;
};
constexpr TypeName kTypeNames[] = {
    {"char", ScalarType::kInt8},      {"int8", ScalarType::kInt8},
    {"uchar", ScalarType::kUint8},    {"uint8", ScalarType::kUint8},
    {"short", ScalarType::kInt16},    {"int16", ScalarType::kInt16},
    {"ushort", ScalarType::kUint16},  {"uint16", ScalarType::kUint16},
    {"int", ScalarType::kInt32},      {"int32", ScalarType::kInt32},
    {"uint", ScalarType::kUint32},    {"uint32", ScalarType::kUint32},
    {"float", ScalarType::kFloat32},  {"float32", ScalarType::kFloat32},
    {"double", ScalarType::kFloat64}, {"float64", ScalarType::kFloat64},
};

bool ParseType(absl::string_view name, ScalarType* type) {
  for (const TypeName& known : kTypeNames) {
    if (name != known.name) continue;
    *type = known.type;
    return true;
  }
  return false;
}

template <typename Value>
double Load(const char* bytes, bool big_endian) {
  char swapped[sizeof(Value)];
  std::memcpy(swapped, bytes, sizeof(Value));
  if (big_endian) std::reverse(swapped, swapped + sizeof(Value));
  Value value;
  std::memcpy(&value, swapped, sizeof(Value));
  return static_cast<double>(value);
}

using Words = std::vector<absl::string_view>;

bool ParseFormat(const Words& words, PlyEncoding* encoding) {
  if (words.size() != 3 || words[2] != "1.0") return false;
  if (words[1] == "ascii")
    *encoding = PlyEncoding::kAscii;
  else if (words[1] == "binary_little_endian")
    *encoding = PlyEncoding::kLittleEndian;
  else if (words[1] == "binary_big_endian")
    *encoding = PlyEncoding::kBigEndian;
  else
    return false;
  return true;
}

bool ParseElement(const Words& words, PlyHeader* header) {
  int64_t count = 0;
  if (words.size() != 3 || !ParseInt(words[2], &count) || count < 0) return false;
  header->elements.push_back({std::string(words[1]), static_cast<uint64_t>(count), {}});
  return true;
}

bool ParseProperty(const Words& words, PlyHeader* header) {
  if (header->elements.empty()) return false;
  PlyProperty property;
  if (words.size() == 5 && words[1] == "list") {
    property.is_list = true;
    if (!ParseType(words[2], &property.count_type)) return false;
  } else if (words.size() != 3) {
    return false;
  }
  if (!ParseType(words[words.size() - 2], &property.type)) return false;
  property.name = std::string(words.back());
  header->elements.back().properties.push_back(std::move(property));
  return true;
}

}  // namespace

int ScalarBytes(ScalarType type) {
  constexpr int kBytes[] = {1, 1, 2, 2, 4, 4, 4, 8};
  return kBytes[static_cast<int>(type)];
}

double ReadScalar(const char* bytes, ScalarType type, bool big_endian) {
  switch (type) {
    case ScalarType::kInt8:
      return Load<int8_t>(bytes, big_endian);
    case ScalarType::kUint8:
      return Load<uint8_t>(bytes, big_endian);
    case ScalarType::kInt16:
      return Load<int16_t>(bytes, big_endian);
    case ScalarType::kUint16:
      return Load<uint16_t>(bytes, big_endian);
    case ScalarType::kInt32:
      return Load<int32_t>(bytes, big_endian);
    case ScalarType::kUint32:
      return Load<uint32_t>(bytes, big_endian);
    case ScalarType::kFloat32:
      return Load<float>(bytes, big_endian);
    case ScalarType::kFloat64:
      return Load<double>(bytes, big_endian);
  }
  return std::numeric_limits<double>::quiet_NaN();
}

int PlyElement::Find(absl::string_view property) const {
  for (size_t k = 0; k < properties.size(); ++k) {
    if (properties[k].name == property) return static_cast<int>(k);
  }
  return -1;
}

absl::StatusOr<PlyHeader> ReadPlyHeader(absl::string_view bytes) {
  TextCursor cursor(bytes);
  absl::string_view line;
  Words words;
  if (!cursor.NextLine(&line) || line != "ply") return BadLine(1, line, "ply");
  // A file whose lines end with \r alone must not lose a data byte that happens to be \n.
  const bool only_cr = bytes.size() > 4 && bytes[3] == '\r' && bytes[4] != '\n';
  PlyHeader header;
  bool has_format = false;
  while (cursor.NextLine(&line)) {
    SplitWords(line, "", 0, &words);
    if (words.empty() || words[0] == "comment" || words[0] == "obj_info") continue;
    if (words[0] == "end_header") {
      if (!has_format) return BadLine(cursor.line(), line, "a format line before it");
      header.bytes = static_cast<size_t>(line.data() - bytes.data()) + line.size();
      header.bytes =
          std::min(bytes.size(), only_cr ? header.bytes + 1 : bytes.size() - cursor.rest().size());
      header.lines = cursor.line();
      return header;
    }
    if (words[0] == "format") {
      if (!ParseFormat(words, &header.encoding)) {
        return BadLine(cursor.line(), line,
                       "format ascii, binary_little_endian or binary_big_endian, 1.0");
      }
      has_format = true;
    } else if (words[0] == "element") {
      if (!ParseElement(words, &header)) return BadLine(cursor.line(), line, "element NAME COUNT");
    } else if (words[0] == "property") {
      if (!ParseProperty(words, &header)) {
        return BadLine(cursor.line(), line, "property TYPE NAME or property list TYPE TYPE NAME");
      }
    } else {
      return BadLine(cursor.line(), line, "format, comment, element, property or end_header");
    }
  }
  return absl::InvalidArgumentError("the PLY header has no end_header");
}

}  // namespace cagefit::client
