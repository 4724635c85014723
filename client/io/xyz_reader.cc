#include <cmath>
#include <vector>

#include "absl/strings/match.h"
#include "client/io/format_readers.h"
#include "client/io/geometry_builder.h"
#include "client/io/text_cursor.h"
#include "core/base/status.h"

namespace cagefit::client {
namespace {

constexpr double kUnitTolerance = 0.02;  // of a normal's length, for files with few digits

// Before any point: a count, or names of columns.
bool IsHeading(const std::vector<absl::string_view>& words) {
  int64_t count = 0;
  if (words.size() == 1) return ParseInt(words[0], &count);
  double value = 0;
  for (const absl::string_view word : words) {
    if (ParseDouble(word, &value)) return false;
  }
  return true;
}

struct Row {
  double values[6];
  int count = 0;  // columns that are numbers, at most 6

  bool has_unit_normal() const {
    if (count < 6) return false;
    const double length = std::hypot(values[3], values[4], values[5]);
    return std::abs(length - 1) < kUnitTolerance;
  }
};

bool ParseRow(const std::vector<absl::string_view>& words, Row* row) {
  row->count = 0;
  for (size_t k = 0; k < words.size() && k < 6; ++k) {
    if (!ParseDouble(words[k], &row->values[k])) break;
    ++row->count;
  }
  return row->count >= 3;
}

}  // namespace

absl::StatusOr<Geometry> ReadXyz(absl::string_view bytes, const ReadLimits& limits) {
  TextCursor cursor(bytes);
  absl::string_view line;
  std::vector<absl::string_view> words;
  GeometryBuilder builder(limits);
  bool all_normals = true, heading_allowed = true;
  Row row;
  while (cursor.NextLine(&line)) {
    if (const size_t comment = line.find("//"); comment != absl::string_view::npos) {
      line = line.substr(0, comment);
    }
    SplitWords(line, ",;", '#', &words);
    if (words.empty()) continue;
    if (!ParseRow(words, &row)) {
      if (!heading_allowed || !IsHeading(words)) {
        return BadLine(cursor.line(), line, "X Y Z, or X Y Z NX NY NZ");
      }
      heading_allowed = false;
      continue;
    }
    heading_allowed = false;
    RETURN_IF_ERROR(builder.AddVertex(row.values[0], row.values[1], row.values[2]));
    all_normals = all_normals && row.has_unit_normal();
    if (all_normals) builder.AddNormal(row.values[3], row.values[4], row.values[5]);
  }
  // Normals of the first lines only are fewer than the vertices and count as none.
  return builder.Finish(NanPoints::kDropFromClouds);
}

}  // namespace cagefit::client
