// Exact evaluation of a Loop subdivision surface anywhere.
//
// A control triangle whose three corners are regular is one box spline. Any other is refined once;
// each of its four triangles then has at most one extraordinary vertex and is a box spline or an
// irregular patch (irregular_patch.h). Beyond boundaries and creases the surface is continued by
// mirrored points: p' = a + b - p across the edge ab of the triangle (a b p).
#ifndef CAGEFIT_CORE_SUBDIV_LIMIT_SURFACE_H_
#define CAGEFIT_CORE_SUBDIV_LIMIT_SURFACE_H_

#include <array>
#include <map>
#include <utility>
#include <vector>

#include "absl/container/inlined_vector.h"
#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "core/mesh/control_mesh.h"
#include "core/mesh/topology.h"
#include "core/subdiv/irregular_patch.h"
#include "core/subdiv/stencils.h"
#include "core/subdiv/surface_point.h"

namespace cagefit {

// Position and derivatives of m points as rows over the control vertices: m x n each. What was not
// asked for has 0 rows.
struct SurfaceStencils {
  StencilMatrix position, du, dv, duu, duv, dvv;
};

// A point as weights of control points (LimitSurface::ControlPoints): index, weight.
using SurfaceRow = absl::InlinedVector<std::pair<int32_t, double>, 24>;

// Immutable; thread-safe.
class LimitSurface {
 public:
  // `tags` must name edges and vertices of `topology` (as ControlMesh::Create checks).
  LimitSurface(const Topology& topology, const CreaseTags& tags);

  // Rows for the points. At an extraordinary vertex du and dv are two tangents, du x dv along the
  // normal, whatever the parametrisation; second derivatives there are INVALID_ARGUMENT, as are
  // points outside their triangle or on none. Both name the point's index.
  absl::StatusOr<SurfaceStencils> Stencils(absl::Span<const SurfacePoint> points,
                                           Derivatives derivatives) const;

  // The control points of all patches at control vertices V (3 x n): V, then the vertices of the
  // mesh refined once. What Evaluate reads.
  void ControlPoints(const Points3d& V, Points3d* control_points) const;

  // Evaluates one point, which must be valid, at ControlPoints. Second derivatives at an
  // extraordinary vertex are not a number.
  SurfaceJet Evaluate(const Points3d& control_points, const SurfacePoint& point,
                      Derivatives derivatives) const;

  // The position at `point`, which must be valid, as a row over the control points: about 12
  // entries that sum to 1. With R = refinement(), the gradient g of a function of the position adds
  // w g to control vertex i for an entry (i, w) with i < n, else w r g to each vertex of an entry r
  // of row i - n of R: gather the g of all points over the control points first, then multiply by R
  // once.
  void PositionRow(const SurfacePoint& point, SurfaceRow* row) const;

  // Vertices of the mesh refined once x control vertices (n): control point n + i is row i of it
  // times V.
  const StencilMatrix& refinement() const { return refinement_; }

  // Whether the point, which must be valid, is an extraordinary vertex: du and dv are tangents that
  // belong to no parametrisation there.
  bool IsExtraordinary(const SurfacePoint& point) const;

  // The same point of the surface as seen from the triangle across the edge from corner c to c + 1,
  // on which it must lie; face is -1 on a boundary.
  SurfacePoint Across(const SurfacePoint& point, int c) const;

  const Topology& topology() const { return topology_; }
  int32_t face_count() const { return static_cast<int32_t>(first_patch_.size()); }
  int64_t vertex_count() const { return refinement_.cols(); }

 private:
  static constexpr int32_t kRegular = -1;
  static constexpr int32_t kMirrored = -1;

  // A triangle of the control mesh or of the refined one.
  struct Patch {
    int32_t begin = 0;         // of its points in points_
    int32_t shape = kRegular;  // or an index into shapes_
    // Regular: per corner 0, or 1 + its position in the open fan (corner_fan.h).
    std::array<int8_t, 3> open = {};
  };

  void AddPatch(const CornerFan (&fans)[3], const Topology& topology, int32_t f, int32_t offset);
  void AddRegularPatch(const CornerFan (&fans)[3], const Topology& topology, int32_t f,
                       int32_t offset);
  void AddIrregularPatch(const CornerFan (&fans)[3], int32_t v, int32_t offset);
  int32_t ShapeOf(const CornerFan& fan);

  // The patch that `point` lies in; writes the weights of its points.
  absl::Span<const int32_t> LocalWeights(const SurfacePoint& point, Derivatives derivatives,
                                         PatchWeights* weights) const;
  absl::Status Check(const SurfacePoint& point, Derivatives derivatives) const;

  Topology topology_;
  StencilMatrix refinement_;          // refined vertices x control vertices
  std::vector<int32_t> first_patch_;  // per control triangle: its patch, or the first of four
  std::vector<char> is_split_;        // per control triangle
  std::vector<Patch> patches_;        // the last one ends the others' points
  std::vector<int32_t> points_;       // indices of control points, or kMirrored
  std::vector<IrregularPatch> shapes_;
  std::map<std::array<int, 5>, int32_t> shape_of_;  // by what a shape's masks depend on
};

}  // namespace cagefit

#endif  // CAGEFIT_CORE_SUBDIV_LIMIT_SURFACE_H_
