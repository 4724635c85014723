#include <array>
#include <cstring>
#include <map>
#include <vector>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "client/io/format_readers.h"
#include "client/io/geometry_builder.h"
#include "client/io/text_cursor.h"
#include "core/base/status.h"

namespace cagefit::client {
namespace {

constexpr size_t kHeaderBytes = 84;    // 80 of text, then the number of triangles
constexpr size_t kTriangleBytes = 50;  // normal, three corners, attributes

// Triangles whose corners at one position are one vertex.
class Soup {
 public:
  explicit Soup(const ReadLimits& limits) : builder_(limits) {}

  absl::Status AddTriangle(const std::array<std::array<double, 3>, 3>& corners) {
    std::array<int64_t, 3> indices;
    for (int c = 0; c < 3; ++c) {
      std::array<double, 3> at = corners[c];
      for (double& x : at) x += 0.0;  // -0 and 0 are one position
      const auto [found, added] = index_.try_emplace(at, builder_.vertex_count());
      if (added) RETURN_IF_ERROR(builder_.AddVertex(at[0], at[1], at[2]));
      indices[c] = found->second;
    }
    return builder_.AddPolygon(indices);
  }

  absl::Status CheckCounts(uint64_t triangles) const { return builder_.CheckCounts(0, triangles); }
  absl::StatusOr<Geometry> Finish() { return builder_.Finish(NanPoints::kRefuse); }

 private:
  GeometryBuilder builder_;
  std::map<std::array<double, 3>, int64_t> index_;
};

uint32_t ClaimedTriangles(absl::string_view bytes) {
  uint32_t count = 0;
  std::memcpy(&count, bytes.data() + kHeaderBytes - 4, 4);
  return count;
}

absl::StatusOr<Geometry> ReadBinary(absl::string_view bytes, const ReadLimits& limits) {
  const uint32_t count = ClaimedTriangles(bytes);
  Soup soup(limits);
  RETURN_IF_ERROR(soup.CheckCounts(count));
  for (uint32_t f = 0; f < count; ++f) {
    float values[9];
    std::memcpy(values, bytes.data() + kHeaderBytes + kTriangleBytes * f + 12, sizeof(values));
    std::array<std::array<double, 3>, 3> corners;
    for (int k = 0; k < 9; ++k) {
      if (!std::isfinite(values[k])) {
        return absl::InvalidArgumentError(
            absl::StrCat("triangle ", f, " (from 0) has a corner that is not finite"));
      }
      corners[k / 3][k % 3] = values[k];
    }
    RETURN_IF_ERROR(soup.AddTriangle(corners));
  }
  return soup.Finish();
}

absl::StatusOr<Geometry> ReadText(absl::string_view bytes, const ReadLimits& limits) {
  TextCursor cursor(bytes);
  absl::string_view line;
  std::vector<absl::string_view> words;
  std::array<std::array<double, 3>, 3> corners;
  int count = 0;
  Soup soup(limits);
  while (cursor.NextLine(&line)) {
    SplitWords(line, "", 0, &words);
    if (words.empty()) continue;
    if (words[0] == "vertex") {
      bool good = words.size() == 4 && count < 3;
      for (int axis = 0; good && axis < 3; ++axis) {
        good = ParseDouble(words[axis + 1], &corners[count][axis]) &&
               std::isfinite(corners[count][axis]);
      }
      if (!good) return BadLine(cursor.line(), line, "vertex X Y Z, three in a facet");
      ++count;
    } else if (words[0] == "endfacet") {
      if (count != 3) return BadLine(cursor.line(), line, "three vertices before it");
      count = 0;
      RETURN_IF_ERROR(soup.AddTriangle(corners));
    }
  }
  if (count != 0) return absl::InvalidArgumentError("the file ends inside a facet");
  return soup.Finish();
}

}  // namespace

absl::StatusOr<Geometry> ReadStl(absl::string_view bytes, const ReadLimits& limits) {
  // Some binary files, too, begin with "solid": their size tells.
  const bool sized = bytes.size() >= kHeaderBytes &&
                     bytes.size() >= kHeaderBytes + kTriangleBytes * ClaimedTriangles(bytes);
  const bool text = absl::StartsWith(bytes, "solid") && absl::StrContains(bytes, "facet");
  if (text) return ReadText(bytes, limits);
  if (sized) return ReadBinary(bytes, limits);
  if (bytes.size() < kHeaderBytes) {
    return absl::InvalidArgumentError(absl::StrCat(
        bytes.size(), " bytes are neither text STL (solid ... facet ...) nor a binary header"));
  }
  return absl::InvalidArgumentError(absl::StrCat("the header claims ", ClaimedTriangles(bytes),
                                                 " triangles; the ", bytes.size() - kHeaderBytes,
                                                 " bytes that follow cannot hold them"));
}

}  // namespace cagefit::client
