#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include "absl/strings/str_cat.h"
#include "client/io/format_readers.h"
#include "client/io/geometry_builder.h"
#include "client/io/ply_header.h"
#include "client/io/text_cursor.h"
#include "core/base/status.h"

namespace cagefit::client {
namespace {

// The body, value by value.
class PlyBody {
 public:
  PlyBody(absl::string_view bytes, const PlyHeader& header)
      : encoding_(header.encoding),
        data_(bytes.substr(header.bytes)),
        text_(data_),
        header_lines_(header.lines) {}

  absl::Status Next(ScalarType type, double* value) {
    if (encoding_ == PlyEncoding::kAscii) return NextText(value);
    const size_t bytes = ScalarBytes(type);
    if (data_.size() - at_ < bytes) return absl::InvalidArgumentError("the file ends there");
    *value = ReadScalar(data_.data() + at_, type, encoding_ == PlyEncoding::kBigEndian);
    at_ += bytes;
    return absl::OkStatus();
  }

  // A lower bound of the bytes that one more element takes.
  size_t LeastBytes(const PlyElement& element) const {
    size_t bytes = 0;
    for (const PlyProperty& property : element.properties) {
      const ScalarType first = property.is_list ? property.count_type : property.type;
      bytes += encoding_ == PlyEncoding::kAscii ? 1 : ScalarBytes(first);
    }
    return bytes;
  }

  size_t bytes_left() const {
    return encoding_ == PlyEncoding::kAscii ? text_.rest().size() : data_.size() - at_;
  }

 private:
  absl::Status NextText(double* value) {
    const absl::string_view word = text_.NextWord();
    if (word.empty()) return absl::InvalidArgumentError("the file ends there");
    if (ParseDouble(word, value)) return absl::OkStatus();
    return BadLine(header_lines_ + text_.line(), word, "a number");
  }

  PlyEncoding encoding_;
  absl::string_view data_;
  size_t at_ = 0;
  TextCursor text_;
  int64_t header_lines_;
};

// Reads one element's values; a list's go to `list` when its property is `list_property`.
absl::Status ReadElement(const PlyElement& element, int list_property, PlyBody* body,
                         std::vector<double>* scalars, std::vector<int64_t>* list) {
  for (size_t p = 0; p < element.properties.size(); ++p) {
    const PlyProperty& property = element.properties[p];
    if (!property.is_list) {
      RETURN_IF_ERROR(body->Next(property.type, &(*scalars)[p]));
      continue;
    }
    double count = 0;
    RETURN_IF_ERROR(body->Next(property.count_type, &count));
    if (!(count >= 0) || count != std::floor(count) ||
        count > static_cast<double>(body->bytes_left())) {
      return absl::InvalidArgumentError(absl::StrCat("its list \"", property.name, "\" claims ",
                                                     count, " entries; ", body->bytes_left(),
                                                     " bytes are left"));
    }
    const bool wanted = static_cast<int>(p) == list_property;
    if (wanted) list->clear();
    for (double k = 0; k < count; ++k) {
      double value = 0;
      RETURN_IF_ERROR(body->Next(property.type, &value));
      if (wanted) list->push_back(static_cast<int64_t>(std::clamp(value, -1e15, 1e15)));
    }
  }
  return absl::OkStatus();
}

absl::Status At(const PlyElement& element, uint64_t index, const absl::Status& status) {
  if (status.ok()) return status;
  return absl::Status(status.code(), absl::StrCat(element.name, " ", index, " (from 0) of ",
                                                  element.count, ": ", status.message()));
}

absl::Status CheckSize(const PlyElement& element, const PlyBody& body) {
  if (element.properties.empty() && element.count > 0) {
    return absl::InvalidArgumentError(absl::StrCat(
        "element ", element.name, " has no properties but a count of ", element.count));
  }
  const size_t least = body.LeastBytes(element);
  if (least == 0 || element.count <= body.bytes_left() / least) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrCat("the header claims ", element.count, " of element ", element.name, "; the ",
                   body.bytes_left(), " bytes that follow cannot hold them"));
}

absl::Status ReadVertices(const PlyElement& element, PlyBody* body, GeometryBuilder* builder) {
  const std::array<int, 3> xyz = {element.Find("x"), element.Find("y"), element.Find("z")};
  const std::array<int, 3> n = {element.Find("nx"), element.Find("ny"), element.Find("nz")};
  for (const int p : xyz) {
    if (p < 0 || element.properties[p].is_list) {
      return absl::InvalidArgumentError("element vertex lacks a property x, y or z");
    }
  }
  const bool normals = n[0] >= 0 && n[1] >= 0 && n[2] >= 0;
  std::vector<double> values(element.properties.size(), 0);
  std::vector<int64_t> unused;
  for (uint64_t k = 0; k < element.count; ++k) {
    RETURN_IF_ERROR(At(element, k, ReadElement(element, -1, body, &values, &unused)));
    RETURN_IF_ERROR(builder->AddVertex(values[xyz[0]], values[xyz[1]], values[xyz[2]]));
    if (normals) builder->AddNormal(values[n[0]], values[n[1]], values[n[2]]);
  }
  return absl::OkStatus();
}

absl::Status ReadFaces(const PlyElement& element, PlyBody* body, GeometryBuilder* builder) {
  int corners = element.Find("vertex_indices");
  if (corners < 0) corners = element.Find("vertex_index");
  if (element.count > 0 && (corners < 0 || !element.properties[corners].is_list)) {
    return absl::InvalidArgumentError("element face lacks a list vertex_indices");
  }
  std::vector<double> values(element.properties.size(), 0);
  std::vector<int64_t> polygon;
  for (uint64_t k = 0; k < element.count; ++k) {
    RETURN_IF_ERROR(At(element, k, ReadElement(element, corners, body, &values, &polygon)));
    RETURN_IF_ERROR(builder->AddPolygon(polygon));
  }
  return absl::OkStatus();
}

absl::Status SkipElements(const PlyElement& element, PlyBody* body) {
  std::vector<double> values(element.properties.size(), 0);
  std::vector<int64_t> unused;
  for (uint64_t k = 0; k < element.count; ++k) {
    RETURN_IF_ERROR(At(element, k, ReadElement(element, -1, body, &values, &unused)));
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<Geometry> ReadPly(absl::string_view bytes, const ReadLimits& limits) {
  ASSIGN_OR_RETURN(const PlyHeader header, ReadPlyHeader(bytes));
  GeometryBuilder builder(limits);
  PlyBody body(bytes, header);
  bool has_vertices = false;
  for (const PlyElement& element : header.elements) {
    RETURN_IF_ERROR(CheckSize(element, body));
    if (element.name == "vertex" && !has_vertices) {
      has_vertices = true;
      RETURN_IF_ERROR(builder.CheckCounts(element.count, 0));
      RETURN_IF_ERROR(ReadVertices(element, &body, &builder));
    } else if (element.name == "face") {
      RETURN_IF_ERROR(builder.CheckCounts(0, element.count));
      RETURN_IF_ERROR(ReadFaces(element, &body, &builder));
    } else {
      RETURN_IF_ERROR(SkipElements(element, &body));
    }
  }
  if (!has_vertices) return absl::InvalidArgumentError("the PLY header has no element vertex");
  return builder.Finish(NanPoints::kDropFromClouds);
}

}  // namespace cagefit::client
