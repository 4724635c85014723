// Collects what a file holds while it is read, within limits. Internal to client/io.
#ifndef CAGEFIT_CLIENT_IO_GEOMETRY_BUILDER_H_
#define CAGEFIT_CLIENT_IO_GEOMETRY_BUILDER_H_

#include <array>
#include <cstdint>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "client/io/geometry_file.h"

namespace cagefit::client {

// What to do with points that are not numbers.
enum class NanPoints { kRefuse, kDropFromClouds };

class GeometryBuilder {
 public:
  explicit GeometryBuilder(const ReadLimits& limits) : limits_(limits) {}

  // RESOURCE_EXHAUSTED naming limit and value. Before memory is taken for what a header claims.
  absl::Status CheckCounts(uint64_t vertices, uint64_t polygons) const;

  absl::Status AddVertex(double x, double y, double z);
  // The normal of the vertex added last; one that is not finite counts as none.
  void AddNormal(double x, double y, double z);
  // Corners are vertex indices from 0; they may name vertices that are yet to come. Fewer than
  // three corners are counted and left out.
  absl::Status AddPolygon(absl::Span<const int64_t> corners);

  int64_t vertex_count() const { return static_cast<int64_t>(vertices_.size()) / 3; }

  // INVALID_ARGUMENT when there is no vertex, an index is out of range, or a coordinate is not
  // finite.
  absl::StatusOr<Geometry> Finish(NanPoints nan_points);

 private:
  absl::Status CheckCorners() const;
  absl::Status CheckFinite() const;
  void DropNanPoints();

  ReadLimits limits_;
  std::vector<double> vertices_;  // x y z ...
  std::vector<float> normals_;    // x y z ..., one per vertex or empty
  std::vector<int64_t> corners_;  // three per triangle
  std::vector<int64_t> polygon_of_triangle_;
  int64_t polygons_ = 0;
};

}  // namespace cagefit::client

#endif  // CAGEFIT_CLIENT_IO_GEOMETRY_BUILDER_H_
