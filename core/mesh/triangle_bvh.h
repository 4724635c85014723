// Bounding-volume hierarchy over triangles: exact closest points.
#ifndef CAGEFIT_CORE_MESH_TRIANGLE_BVH_H_
#define CAGEFIT_CORE_MESH_TRIANGLE_BVH_H_

#include <cstdint>
#include <limits>
#include <vector>

#include "core/base/types.h"

namespace cagefit {

struct ClosestPoint {
  int32_t triangle = -1;  // -1: nothing within the search radius
  double u = 0, v = 0;    // point = (1 - u - v) a + u b + v c
  double distance = std::numeric_limits<double>::infinity();
  Eigen::Vector3d point = Eigen::Vector3d::Zero();
};

// Closest point of triangle (a, b, c) to x [ericson2005, 5.1.5], `triangle` being 0. Exact but for
// rounding; needles with an angle below 1e-8, and triangles without area, act as their edges.
ClosestPoint ClosestPointOnTriangle(const Eigen::Vector3d& x, const Eigen::Vector3d& a,
                                    const Eigen::Vector3d& b, const Eigen::Vector3d& c);

// Copies what it needs. Build is O(F log F); queries are thread-safe and do not allocate.
class TriangleBvh {
 public:
  TriangleBvh() = default;
  TriangleBvh(const Points3d& vertices, const Triangles& triangles) { Build(vertices, triangles); }

  // Replaces the content; buffers keep their capacity. Vertices must be finite, indices in range.
  void Build(const Points3d& vertices, const Triangles& triangles);

  // Closest point to x nearer than max_distance, of equally near triangles that of the lowest
  // index; triangle == -1 when there is none.
  ClosestPoint Closest(const Eigen::Vector3d& x,
                       double max_distance = std::numeric_limits<double>::infinity()) const;

  bool empty() const { return order_.empty(); }

 private:
  struct Node {
    Eigen::Vector3f min, max;  // conservative: rounded outwards
    int32_t begin =
        0;  // leaf: first entry of order_; inner: index of the left child, right = left + 1
    int32_t count = 0;  // leaf: number of triangles; inner: 0
  };

  void Split(const Points3d& vertices, const Triangles& triangles);

  std::vector<Node> nodes_;
  std::vector<int32_t> order_;
  Points3d corners_;  // 3 x 3F in leaf order: a, b, c of each triangle
};

}  // namespace cagefit

#endif  // CAGEFIT_CORE_MESH_TRIANGLE_BVH_H_
