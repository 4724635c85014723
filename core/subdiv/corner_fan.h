// The triangles around one corner of a triangle, as far as the surface is smooth across edges.
#ifndef CAGEFIT_CORE_SUBDIV_CORNER_FAN_H_
#define CAGEFIT_CORE_SUBDIV_CORNER_FAN_H_

#include <cstdint>
#include <vector>

#include "core/mesh/topology.h"
#include "core/subdiv/sharp_features.h"

namespace cagefit {

// A vertex as one of its triangles sees it. Closed: the whole ring, counter-clockwise from the next
// corner of the triangle. Open (two or more sharp edges meet): the ring between the two sharp edges
// on either side of the triangle, from the clockwise one to the other.
struct CornerFan {
  VertexRule rule = VertexRule::kSmooth;
  bool closed = true;
  int position = 0;           // of the triangle's next corner in the ring; 0 when closed
  int dart = -1;              // closed: position of the only sharp edge, or -1
  std::vector<int32_t> ring;  // vertices

  int faces() const { return static_cast<int>(ring.size()) - (closed ? 0 : 1); }
  // Whether the surface around the corner is a regular box spline, beyond a sharp edge continued by
  // mirrored points.
  bool IsRegular() const {
    return closed ? rule == VertexRule::kSmooth && dart < 0 && faces() == 6
                  : rule == VertexRule::kCrease && faces() == 3;
  }
};

// The fan at corner c of triangle f.
CornerFan WalkCornerFan(const Topology& topology, const SharpFeatures& sharp, int32_t f, int c);

}  // namespace cagefit

#endif  // CAGEFIT_CORE_SUBDIV_CORNER_FAN_H_
