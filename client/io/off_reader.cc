#include <vector>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "client/io/format_readers.h"
#include "client/io/geometry_builder.h"
#include "client/io/text_cursor.h"
#include "core/base/status.h"

namespace cagefit::client {
namespace {

class OffReader {
 public:
  OffReader(absl::string_view bytes, const ReadLimits& limits)
      : cursor_(bytes), bytes_(bytes.size()), builder_(limits) {}

  absl::StatusOr<Geometry> Read() {
    int64_t vertices = 0, faces = 0;
    RETURN_IF_ERROR(ReadHeader(&vertices, &faces));
    RETURN_IF_ERROR(builder_.CheckCounts(vertices, faces));
    for (int64_t k = 0; k < vertices; ++k) RETURN_IF_ERROR(ReadVertex(k, vertices));
    for (int64_t k = 0; k < faces; ++k) RETURN_IF_ERROR(ReadFace(k, faces));
    return builder_.Finish(NanPoints::kRefuse);
  }

 private:
  // The words of the next line that has any.
  bool NextWords() {
    while (cursor_.NextLine(&line_)) {
      SplitWords(line_, "", '#', &words_);
      if (!words_.empty()) return true;
    }
    return false;
  }

  absl::Status ReadHeader(int64_t* vertices, int64_t* faces) {
    constexpr char kExpected[] = "OFF, COFF, NOFF or CNOFF";
    if (!NextWords()) return absl::InvalidArgumentError("the file has no line; expected OFF");
    const absl::string_view kind = words_[0];
    if (kind != "OFF" && kind != "COFF" && kind != "NOFF" && kind != "CNOFF") {
      return BadLine(cursor_.line(), line_, kExpected);
    }
    has_normals_ = absl::StrContains(kind, 'N');
    words_.erase(words_.begin());
    if (!words_.empty() && words_[0] == "BINARY") {
      return absl::InvalidArgumentError("binary OFF is not read; save it as text or as PLY");
    }
    if (words_.empty() && !NextWords()) words_.clear();
    // The number of edges, the third, is left out by some and of no use.
    if (words_.size() < 2 || !ParseInt(words_[0], vertices) || !ParseInt(words_[1], faces) ||
        *vertices < 0 || *faces < 0) {
      return BadLine(cursor_.line(), line_, "the numbers of vertices, faces and edges");
    }
    // Two bytes a line at least.
    const int64_t most = bytes_ / 2;
    if (*vertices > most || *faces > most - *vertices) {
      return absl::InvalidArgumentError(absl::StrCat("the header claims ", *vertices,
                                                     " vertices and ", *faces, " faces; ", bytes_,
                                                     " bytes cannot hold them"));
    }
    return absl::OkStatus();
  }

  absl::Status ReadVertex(int64_t index, int64_t count) {
    if (!NextWords()) return EndsAt("vertex", index, count);
    const size_t wanted = has_normals_ ? 6 : 3;
    double values[6];
    bool good = words_.size() >= wanted;
    for (size_t k = 0; good && k < wanted; ++k) good = ParseDouble(words_[k], &values[k]);
    if (!good) {
      return BadLine(
          cursor_.line(), line_,
          absl::StrCat("vertex ", index, " (from 0) of ", count, ", ", wanted, " numbers"));
    }
    RETURN_IF_ERROR(builder_.AddVertex(values[0], values[1], values[2]));
    if (has_normals_) builder_.AddNormal(values[3], values[4], values[5]);
    return absl::OkStatus();
  }

  absl::Status ReadFace(int64_t index, int64_t count) {
    if (!NextWords()) return EndsAt("face", index, count);
    int64_t size = 0;
    bool good = ParseInt(words_[0], &size) && size >= 0 &&
                size < static_cast<int64_t>(words_.size());  // colours may follow
    corners_.clear();
    for (int64_t k = 1; good && k <= size; ++k) {
      int64_t corner = 0;
      good = ParseInt(words_[k], &corner);
      corners_.push_back(corner);
    }
    if (good) return builder_.AddPolygon(corners_);
    return BadLine(cursor_.line(), line_,
                   absl::StrCat("face ", index, " (from 0) of ", count,
                                ", its number of corners and their vertices"));
  }

  static absl::Status EndsAt(absl::string_view what, int64_t index, int64_t count) {
    return absl::InvalidArgumentError(
        absl::StrCat("the file ends at ", what, " ", index, " (from 0) of ", count));
  }

  TextCursor cursor_;
  int64_t bytes_;
  GeometryBuilder builder_;
  bool has_normals_ = false;
  absl::string_view line_;
  std::vector<absl::string_view> words_;
  std::vector<int64_t> corners_;
};

}  // namespace

absl::StatusOr<Geometry> ReadOff(absl::string_view bytes, const ReadLimits& limits) {
  return OffReader(bytes, limits).Read();
}

}  // namespace cagefit::client
