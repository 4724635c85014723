#include <Eigen/Core>
#include <cmath>
#include <string>
#include <vector>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "client/io/format_readers.h"
#include "client/io/geometry_builder.h"
#include "client/io/text_cursor.h"
#include "core/base/status.h"

namespace cagefit::client {
namespace {

constexpr char kTagPrefix[] = "# cagefit ";

class ObjReader {
 public:
  ObjReader(const ReadLimits& limits, CreaseTags* tags) : builder_(limits), tags_(tags) {}

  absl::StatusOr<Geometry> Read(absl::string_view bytes) {
    TextCursor cursor(bytes);
    absl::string_view line;
    std::string joined;
    while (cursor.NextLine(&line)) {
      while (absl::EndsWith(line, "\\")) {
        // Continued on the next line.
        absl::StrAppend(&joined, line.substr(0, line.size() - 1), " ");
        if (!cursor.NextLine(&line)) line = "";
      }
      if (!joined.empty()) {
        joined.append(line.data(), line.size());
        line = joined;
      }
      RETURN_IF_ERROR(ReadLine(cursor.line(), line));
      joined.clear();
    }
    ASSIGN_OR_RETURN(Geometry geometry, builder_.Finish(NanPoints::kRefuse));
    RETURN_IF_ERROR(CheckReferences(geometry.mesh.vertices.cols()));
    TakeNormals(&geometry);
    return geometry;
  }

 private:
  absl::Status ReadLine(int64_t number, absl::string_view line) {
    if (absl::StartsWith(line, kTagPrefix)) return ReadTag(number, line);
    SplitWords(line, "", '#', &words_);
    if (words_.empty()) return absl::OkStatus();
    if (words_[0] == "v") {
      double p[3];
      if (!ReadVector(p)) return BadLine(number, line, "v X Y Z");
      return builder_.AddVertex(p[0], p[1], p[2]);
    }
    if (words_[0] == "vn") {
      double n[3];
      if (!ReadVector(n)) return BadLine(number, line, "vn X Y Z");
      normals_.emplace_back(n[0], n[1], n[2]);
      return absl::OkStatus();
    }
    if (words_[0] == "f") return ReadFace(number, line);
    return absl::OkStatus();
  }

  bool ReadVector(double* values) {
    if (words_.size() < 4) return false;
    for (int axis = 0; axis < 3; ++axis) {
      if (!ParseDouble(words_[axis + 1], values + axis)) return false;
    }
    return true;
  }

  // Corner A, A/T, A//N or A/T/N; negative numbers count from the end.
  bool ReadCorner(absl::string_view word, int64_t* vertex, int64_t* normal) {
    const size_t first = word.find('/');
    if (!ParseInt(word.substr(0, first), vertex) || *vertex == 0) return false;
    *vertex += *vertex < 0 ? builder_.vertex_count() : -1;
    *normal = -1;
    const size_t last = word.rfind('/');
    if (first == last || last + 1 == word.size()) return true;
    if (!ParseInt(word.substr(last + 1), normal) || *normal == 0) return false;
    *normal += *normal < 0 ? static_cast<int64_t>(normals_.size()) : -1;
    return true;
  }

  absl::Status ReadFace(int64_t number, absl::string_view line) {
    corners_.clear();
    for (size_t k = 1; k < words_.size(); ++k) {
      int64_t vertex = 0, normal = -1;
      if (!ReadCorner(words_[k], &vertex, &normal)) {
        return BadLine(number, line, "f with corners A, A/T, A//N or A/T/N, not 0");
      }
      if (vertex < 0) return BadLine(number, line, "indices of vertices above it");
      // Normals may come later in the file, but not vertices that negative indices name.
      corners_.push_back(vertex);
      corner_normals_.push_back({vertex, normal, number});
    }
    return builder_.AddPolygon(corners_);
  }

  absl::Status ReadTag(int64_t number, absl::string_view line) {
    SplitWords(line, "", 0, &words_);  // # cagefit crease A B, # cagefit corner A
    int64_t a = 0, b = 0;
    const bool crease = words_.size() == 5 && words_[2] == "crease" && ParseInt(words_[3], &a) &&
                        ParseInt(words_[4], &b) && b >= 1 && b <= INT32_MAX;
    const bool corner = words_.size() == 4 && words_[2] == "corner" && ParseInt(words_[3], &a);
    if (!(crease || corner) || a < 1 || a > INT32_MAX) {
      return BadLine(number, line, "# cagefit crease A B or # cagefit corner A");
    }
    if (crease) {
      creases_.edges.push_back({static_cast<int32_t>(a - 1), static_cast<int32_t>(b - 1)});
    } else {
      creases_.corners.push_back(static_cast<int32_t>(a - 1));
    }
    return absl::OkStatus();
  }

  absl::Status CheckReferences(int64_t vertices) {
    for (const CornerNormal& corner : corner_normals_) {
      // Also of faces with fewer than three corners, which the builder leaves out.
      if (corner.vertex >= vertices) {
        return absl::InvalidArgumentError(absl::StrCat("line ", corner.line, " names vertex ",
                                                       corner.vertex + 1, " of ", vertices));
      }
      if (corner.normal < static_cast<int64_t>(normals_.size())) continue;
      return absl::InvalidArgumentError(absl::StrCat("line ", corner.line, " names normal ",
                                                     corner.normal + 1, " of ", normals_.size()));
    }
    for (const auto& edge : creases_.edges) {
      if (edge[0] < vertices && edge[1] < vertices) continue;
      return absl::InvalidArgumentError(
          absl::StrCat("a crease names vertex ", std::max(edge[0], edge[1]) + 1, " of ", vertices));
    }
    if (tags_ != nullptr) *tags_ = std::move(creases_);
    return absl::OkStatus();
  }

  void TakeNormals(Geometry* geometry) const {
    const int64_t count = geometry->mesh.vertices.cols();
    Points3d sums = Points3d::Zero(3, count);
    if (geometry->polygons == 0) {
      if (static_cast<int64_t>(normals_.size()) != count) return;
      for (int64_t v = 0; v < count; ++v) sums.col(v) = normals_[v];
    }
    for (const CornerNormal& corner : corner_normals_) {
      if (corner.normal < 0) return;
      sums.col(corner.vertex) += normals_[corner.normal];
    }
    for (int64_t v = 0; v < count; ++v) sums.col(v).stableNormalize();
    if (sums.allFinite()) geometry->normals = sums.cast<float>();
  }

  struct CornerNormal {
    int64_t vertex, normal, line;  // normal -1: none
  };

  GeometryBuilder builder_;
  CreaseTags* tags_;
  CreaseTags creases_;
  std::vector<Eigen::Vector3d> normals_;
  std::vector<CornerNormal> corner_normals_;
  std::vector<int64_t> corners_;
  std::vector<absl::string_view> words_;
};

}  // namespace

absl::StatusOr<Geometry> ReadObj(absl::string_view bytes, const ReadLimits& limits,
                                 CreaseTags* tags) {
  return ObjReader(limits, tags).Read(bytes);
}

}  // namespace cagefit::client
