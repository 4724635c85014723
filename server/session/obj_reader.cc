#include "server/session/obj_reader.h"

#include <algorithm>
#include <vector>

#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "core/base/status.h"

namespace cagefit::server {
namespace {

absl::Status BadLine(int64_t line, absl::string_view text) {
  return absl::InvalidArgumentError(
      absl::StrCat("line ", line, " is \"", text.substr(0, 80),
                   "\"; expected v x y z, f a b c, # cagefit crease a b or # cagefit corner a"));
}

template <typename Value, typename Parse>
bool ReadThree(const std::vector<absl::string_view>& words, const Parse& parse,
               std::vector<Value>* values) {
  if (words.size() != 4) return false;
  for (int axis = 0; axis < 3; ++axis) {
    Value value;
    if (!parse(words[axis + 1], &value)) return false;
    values->push_back(value);
  }
  return true;
}

bool ReadIndex(absl::string_view word, int32_t* value) {
  return absl::SimpleAtoi(word, value) && (*value)-- >= 1;
}

// # cagefit crease A B, # cagefit corner A
bool ReadTag(const std::vector<absl::string_view>& words, CreaseTags* tags) {
  int32_t a = 0, b = 0;
  if (words.size() == 5 && words[2] == "crease") {
    if (!ReadIndex(words[3], &a) || !ReadIndex(words[4], &b)) return false;
    tags->edges.push_back({a, b});
    return true;
  }
  if (words.size() != 4 || words[2] != "corner" || !ReadIndex(words[3], &a)) return false;
  tags->corners.push_back(a);
  return true;
}

}  // namespace

absl::StatusOr<ControlMesh> ReadTemplateObj(absl::string_view text, int32_t max_vertices) {
  std::vector<double> coordinates;
  std::vector<int32_t> indices;
  CreaseTags tags;
  const auto parse_double = [](absl::string_view word, double* value) {
    return absl::SimpleAtod(word, value);
  };
  int64_t line = 0;
  for (absl::string_view raw : absl::StrSplit(text, '\n')) {
    ++line;
    const absl::string_view stripped = absl::StripAsciiWhitespace(raw);
    const bool is_tag = absl::StartsWith(stripped, "# cagefit ");
    if (stripped.empty() || (stripped[0] == '#' && !is_tag)) continue;
    const std::vector<absl::string_view> words = absl::StrSplit(stripped, ' ', absl::SkipEmpty());
    const bool good = is_tag            ? ReadTag(words, &tags)
                      : words[0] == "v" ? ReadThree(words, parse_double, &coordinates)
                      : words[0] == "f" ? ReadThree(words, ReadIndex, &indices)
                                        : false;
    if (!good) return BadLine(line, stripped);
    if (coordinates.size() > 3 * static_cast<size_t>(max_vertices)) {
      return absl::InvalidArgumentError(
          absl::StrCat("line ", line, ": more than ", max_vertices, " vertices"));
    }
  }
  Points3d vertices(3, coordinates.size() / 3);
  std::copy(coordinates.begin(), coordinates.end(), vertices.data());
  Triangles triangles(3, indices.size() / 3);
  std::copy(indices.begin(), indices.end(), triangles.data());
  return ControlMesh::Create(std::move(vertices), std::move(triangles), std::move(tags));
}

}  // namespace cagefit::server
