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
  return absl::InvalidArgumentError(absl::StrCat("line ", line, " is \"", text.substr(0, 80),
                                                 "\"; expected v x y z, f a b c or a tag"));
}

// Reads the `count` words that follow the first `from` ones, and are the last.
template <typename Value, typename Parse>
bool ReadValues(const std::vector<absl::string_view>& words, size_t from, size_t count,
                const Parse& parse, std::vector<Value>* values) {
  if (words.size() != from + count) return false;
  for (size_t k = from; k < words.size(); ++k) {
    Value value;
    if (!parse(words[k], &value)) return false;
    values->push_back(value);
  }
  return true;
}

}  // namespace

absl::StatusOr<ControlMesh> ReadTemplateObj(absl::string_view text, int32_t max_vertices) {
  std::vector<double> coordinates;
  std::vector<int32_t> indices, creases;
  CreaseTags tags;
  const auto parse_double = [](absl::string_view word, double* value) {
    return absl::SimpleAtod(word, value);
  };
  const auto parse_index = [](absl::string_view word, int32_t* value) {
    return absl::SimpleAtoi(word, value) && (*value)-- >= 1;
  };
  int64_t line = 0;
  for (absl::string_view raw : absl::StrSplit(text, '\n')) {
    ++line;
    const absl::string_view stripped = absl::StripAsciiWhitespace(raw);
    const bool tag = absl::StartsWith(stripped, "# cagefit c");
    if (stripped.empty() || (stripped[0] == '#' && !tag)) continue;
    const std::vector<absl::string_view> words = absl::StrSplit(stripped, ' ', absl::SkipEmpty());
    const absl::string_view what = words[tag ? 2 : 0];
    const bool good = what == "v"        ? ReadValues(words, 1, 3, parse_double, &coordinates)
                      : what == "f"      ? ReadValues(words, 1, 3, parse_index, &indices)
                      : what == "crease" ? ReadValues(words, 3, 2, parse_index, &creases)
                      : what == "corner" ? ReadValues(words, 3, 1, parse_index, &tags.corners)
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
  for (size_t k = 0; k < creases.size(); k += 2) tags.edges.push_back({creases[k], creases[k + 1]});
  return ControlMesh::Create(std::move(vertices), std::move(triangles), std::move(tags));
}

}  // namespace cagefit::server
