#include "core/subdiv/corner_fan.h"

#include <algorithm>

namespace cagefit {

namespace {

int32_t Next(int32_t h) { return h % 3 == 2 ? h - 2 : h + 1; }
int32_t Previous(int32_t h) { return h % 3 == 0 ? h + 2 : h - 1; }

}  // namespace

CornerFan WalkCornerFan(const Topology& topology, const SharpFeatures& sharp, int32_t f, int c) {
  const int32_t start = 3 * f + c;  // half-edges below leave the corner
  const int32_t v = topology.triangles()(c, f);
  const auto is_sharp = [&](int32_t h) {
    return sharp.sharp_edge[topology.triangle_edge(h / 3, h % 3)] != 0;
  };
  const auto end = [&](int32_t h) { return topology.triangles().data()[Next(h)]; };

  CornerFan fan;
  fan.rule = sharp.vertex_rule[v];
  const absl::Span<const int32_t> edges = topology.RingEdges(v);
  fan.closed = std::count_if(edges.begin(), edges.end(),
                             [&](int32_t e) { return sharp.sharp_edge[e] != 0; }) < 2;
  int32_t first = start;
  if (!fan.closed) {
    for (; !is_sharp(first); first = Next(topology.opposite(first))) ++fan.position;
  }
  int32_t h = first;
  while (true) {
    if (fan.closed && is_sharp(h)) fan.dart = static_cast<int>(fan.ring.size());
    fan.ring.push_back(end(h));
    const int32_t last = Previous(h);  // the other edge of the triangle at the corner
    if (!fan.closed && is_sharp(last)) {
      fan.ring.push_back(topology.triangles().data()[last]);
      break;
    }
    h = topology.opposite(last);
    if (h == first) break;
  }
  return fan;
}

}  // namespace cagefit
