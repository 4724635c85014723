#include <cstring>
#include <limits>
#include <map>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "client/io/format_readers.h"
#include "client/io/geometry_builder.h"
#include "client/io/lzf.h"
#include "client/io/ply_header.h"
#include "client/io/text_cursor.h"
#include "core/base/status.h"

namespace cagefit::client {
namespace {

struct Field {
  std::string name;
  ScalarType type = ScalarType::kFloat32;
  int64_t count = 1;  // values in it
  int64_t offset = 0, bytes = 0;
};

struct PcdHeader {
  std::vector<Field> fields;
  int64_t points = 0;
  int64_t row_bytes = 0;
  std::string data;  // ascii, binary, binary_compressed

  // The field with that name, or null.
  const Field* Find(absl::string_view name) const {
    for (const Field& field : fields) {
      if (field.name == name) return &field;
    }
    return nullptr;
  }
};

struct TypeName {
  absl::string_view kind;
  int64_t bytes;
  ScalarType type;
};
constexpr TypeName kTypeNames[] = {{"I", 1, ScalarType::kInt8},    {"U", 1, ScalarType::kUint8},
                                   {"I", 2, ScalarType::kInt16},   {"U", 2, ScalarType::kUint16},
                                   {"I", 4, ScalarType::kInt32},   {"U", 4, ScalarType::kUint32},
                                   {"F", 4, ScalarType::kFloat32}, {"F", 8, ScalarType::kFloat64}};

bool ParseType(absl::string_view kind, int64_t bytes, ScalarType* type) {
  for (const TypeName& known : kTypeNames) {
    if (kind != known.kind || bytes != known.bytes) continue;
    *type = known.type;
    return true;
  }
  return false;
}

using HeaderLines = std::map<std::string, std::vector<std::string>>;

absl::StatusOr<HeaderLines> ReadHeaderLines(TextCursor* cursor) {
  HeaderLines lines;
  absl::string_view line;
  std::vector<absl::string_view> words;
  while (cursor->NextLine(&line)) {
    SplitWords(line, "", '#', &words);
    if (words.empty()) continue;
    std::string keyword(words[0]);
    if (keyword == "COLUMNS") keyword = "FIELDS";
    static constexpr absl::string_view kKnown[] = {"VERSION", "FIELDS", "SIZE",   "TYPE",
                                                   "COUNT",   "WIDTH",  "HEIGHT", "VIEWPOINT",
                                                   "POINTS",  "DATA"};
    if (std::find(std::begin(kKnown), std::end(kKnown), keyword) == std::end(kKnown)) {
      return BadLine(cursor->line(), line, "a PCD header: VERSION, FIELDS, ..., DATA");
    }
    lines[keyword] = std::vector<std::string>(words.begin() + 1, words.end());
    if (keyword == "DATA") return lines;
  }
  return absl::InvalidArgumentError("the PCD header has no DATA");
}

absl::Status ReadNumber(const HeaderLines& lines, const std::string& keyword, int64_t* value) {
  const auto found = lines.find(keyword);
  if (found != lines.end() && found->second.size() == 1 && ParseInt(found->second[0], value) &&
      *value >= 0 && *value <= (int64_t{1} << 31)) {
    return absl::OkStatus();
  }
  return absl::InvalidArgumentError(
      absl::StrCat("the PCD header lacks a sound ", keyword, "; expected one number"));
}

absl::Status ReadFields(const HeaderLines& lines, PcdHeader* header) {
  const auto list = [&](const std::string& keyword) {
    const auto found = lines.find(keyword);
    return found == lines.end() ? std::vector<std::string>() : found->second;
  };
  const std::vector<std::string> names = list("FIELDS"), sizes = list("SIZE"), types = list("TYPE");
  std::vector<std::string> counts = list("COUNT");
  if (counts.empty()) counts.assign(names.size(), "1");
  if (names.empty() || sizes.size() != names.size() || types.size() != names.size() ||
      counts.size() != names.size()) {
    return absl::InvalidArgumentError(
        "the PCD header needs FIELDS, SIZE, TYPE and COUNT of the same length");
  }
  for (size_t k = 0; k < names.size(); ++k) {
    Field field;
    int64_t size = 0;
    field.name = names[k];
    // Padding ("_") may have any size.
    if (!ParseInt(sizes[k], &size) || size < 1 || size > 8 || !ParseInt(counts[k], &field.count) ||
        field.count < 1 || field.count > 100'000 ||
        (!ParseType(types[k], size, &field.type) && field.name != "_" && size != 8)) {
      return absl::InvalidArgumentError(absl::StrCat("PCD field ", field.name, " has SIZE ",
                                                     sizes[k], ", TYPE ", types[k], ", COUNT ",
                                                     counts[k], ", which is not read"));
    }
    field.offset = header->row_bytes;
    field.bytes = size * field.count;
    header->row_bytes += field.bytes;
    header->fields.push_back(std::move(field));
  }
  return absl::OkStatus();
}

absl::StatusOr<PcdHeader> ReadHeader(TextCursor* cursor) {
  ASSIGN_OR_RETURN(const HeaderLines lines, ReadHeaderLines(cursor));
  PcdHeader header;
  RETURN_IF_ERROR(ReadFields(lines, &header));
  for (const char* axis : {"x", "y", "z"}) {
    const Field* field = header.Find(axis);
    const bool number =
        field != nullptr && field->count == 1 && field->bytes == ScalarBytes(field->type);
    if (!number) return absl::InvalidArgumentError(absl::StrCat("no PCD field ", axis));
  }
  if (lines.count("POINTS") > 0) {
    RETURN_IF_ERROR(ReadNumber(lines, "POINTS", &header.points));
  } else {
    int64_t width = 0, height = 0;
    RETURN_IF_ERROR(ReadNumber(lines, "WIDTH", &width));
    RETURN_IF_ERROR(ReadNumber(lines, "HEIGHT", &height));
    header.points = width * height;
  }
  const std::vector<std::string>& data = lines.at("DATA");
  if (data.size() != 1 ||
      (data[0] != "ascii" && data[0] != "binary" && data[0] != "binary_compressed")) {
    return absl::InvalidArgumentError("PCD DATA is not ascii, binary or binary_compressed");
  }
  header.data = data[0];
  return header;
}

// Offset of each field in the words of a text row.
absl::StatusOr<Geometry> ReadText(const PcdHeader& header, TextCursor* cursor,
                                  GeometryBuilder* builder,
                                  const std::vector<const Field*>& wanted) {
  std::vector<size_t> columns;
  size_t row_words = 0;
  for (const Field* field : wanted) {
    size_t column = 0;
    for (const Field* f = header.fields.data(); f != field; ++f) column += f->count;
    columns.push_back(column);
  }
  for (const Field& field : header.fields) row_words += field.count;
  absl::string_view line;
  std::vector<absl::string_view> words;
  for (int64_t k = 0; k < header.points;) {
    if (!cursor->NextLine(&line)) {
      return absl::InvalidArgumentError(
          absl::StrCat("the file ends at point ", k, " (from 0) of ", header.points));
    }
    SplitWords(line, "", '#', &words);
    if (words.empty()) continue;
    double values[6] = {};
    // Padding is written by some and left out by others: columns before it are safe.
    bool good = true;
    for (size_t c = 0; good && c < columns.size(); ++c) {
      good = columns[c] < words.size() && ParseDouble(words[columns[c]], &values[c]);
    }
    if (!good) {
      return BadLine(cursor->line(), line, absl::StrCat(row_words, " numbers of a point"));
    }
    RETURN_IF_ERROR(builder->AddVertex(values[0], values[1], values[2]));
    if (columns.size() == 6) builder->AddNormal(values[3], values[4], values[5]);
    ++k;
  }
  return builder->Finish(NanPoints::kDropFromClouds);
}

// Rows point by point (binary) or field by field (binary_compressed).
absl::StatusOr<Geometry> ReadRows(const PcdHeader& header, absl::string_view data, bool by_field,
                                  GeometryBuilder* builder,
                                  const std::vector<const Field*>& wanted) {
  for (int64_t k = 0; k < header.points; ++k) {
    double values[6] = {};
    for (size_t c = 0; c < wanted.size(); ++c) {
      const Field& field = *wanted[c];
      const int64_t at = by_field ? field.offset * header.points + field.bytes * k
                                  : header.row_bytes * k + field.offset;
      values[c] = ReadScalar(data.data() + at, field.type, /*big_endian=*/false);
    }
    RETURN_IF_ERROR(builder->AddVertex(values[0], values[1], values[2]));
    if (wanted.size() == 6) builder->AddNormal(values[3], values[4], values[5]);
  }
  return builder->Finish(NanPoints::kDropFromClouds);
}

absl::StatusOr<std::string> Decompress(const PcdHeader& header, absl::string_view data) {
  uint32_t sizes[2];  // compressed, then not
  if (data.size() < sizeof(sizes)) return absl::InvalidArgumentError("the file ends after DATA");
  std::memcpy(sizes, data.data(), sizeof(sizes));
  data.remove_prefix(sizeof(sizes));
  if (sizes[0] > data.size()) {
    return absl::InvalidArgumentError(
        absl::StrCat("DATA claims ", sizes[0], " compressed bytes; the file has ", data.size()));
  }
  if (sizes[1] != header.row_bytes * header.points) {
    return absl::InvalidArgumentError(absl::StrCat("DATA claims ", sizes[1], " bytes; ",
                                                   header.points, " points need ",
                                                   header.row_bytes * header.points));
  }
  return DecompressLzf(data.substr(0, sizes[0]), sizes[1]);
}

}  // namespace

absl::StatusOr<Geometry> ReadPcd(absl::string_view bytes, const ReadLimits& limits) {
  TextCursor cursor(bytes);
  ASSIGN_OR_RETURN(const PcdHeader header, ReadHeader(&cursor));
  GeometryBuilder builder(limits);
  RETURN_IF_ERROR(builder.CheckCounts(header.points, 0));
  std::vector<const Field*> wanted;
  for (const char* name : {"x", "y", "z", "normal_x", "normal_y", "normal_z"}) {
    const Field* field = header.Find(name);
    if (field != nullptr && field->count == 1) wanted.push_back(field);
  }
  if (wanted.size() != 6) wanted.resize(3);
  if (header.data == "ascii") return ReadText(header, &cursor, &builder, wanted);
  if (header.data == "binary_compressed") {
    ASSIGN_OR_RETURN(const std::string data, Decompress(header, cursor.rest()));
    return ReadRows(header, data, /*by_field=*/true, &builder, wanted);
  }
  const auto left = static_cast<int64_t>(cursor.rest().size());
  if (left / header.row_bytes < header.points) {
    return absl::InvalidArgumentError(absl::StrCat(
        "the file ends at point ", left / header.row_bytes, " (from 0) of ", header.points));
  }
  return ReadRows(header, cursor.rest(), /*by_field=*/false, &builder, wanted);
}

}  // namespace cagefit::client
