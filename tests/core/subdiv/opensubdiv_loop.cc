#include "tests/core/subdiv/opensubdiv_loop.h"

#include <opensubdiv/far/primvarRefiner.h>

#include <algorithm>
#include <utility>

#include "core/subdiv/refine.h"
#include "tests/core/subdiv/opensubdiv_mesh.h"

namespace cagefit::testing {

namespace {

namespace Far = OpenSubdiv::Far;

struct Point {
  Eigen::Vector3d p = Eigen::Vector3d::Zero();
  void Clear() { p.setZero(); }
  void AddWithWeight(const Point& other, double weight) { p += weight * other.p; }
};
using Points = std::vector<Point>;

std::unique_ptr<Far::TopologyRefiner> CreateRefiner(int32_t vertex_count,
                                                    const Triangles& triangles,
                                                    const CreaseTags& tags, int depth) {
  std::unique_ptr<Far::TopologyRefiner> refiner = OpenSubdivMesh(vertex_count, triangles, tags);
  Far::TopologyRefiner::UniformOptions options(depth);
  options.fullTopologyInLastLevel = true;  // limit masks ask for it
  refiner->RefineUniform(options);
  return refiner;
}

Points ToPoints(const Points3d& V) {
  Points points(V.cols());
  for (int64_t v = 0; v < V.cols(); ++v) points[v].p = V.col(v);
  return points;
}

// Vertices of level `to` from those of level `from`, numbered as OpenSubdiv does.
Points Refine(const Far::TopologyRefiner& refiner, Points points, int from, int to) {
  const Far::PrimvarRefinerReal<double> primvars(refiner);
  for (int level = from + 1; level <= to; ++level) {
    Points finer(refiner.GetLevel(level).GetNumVertices());
    primvars.Interpolate(level, points, finer);
    points = std::move(finer);
  }
  return points;
}

// The triangles around a vertex: vertex 0, its ring from 1 on.
struct Star {
  Triangles triangles;
  CreaseTags tags;
};

Star StarOf(const Topology& topology, const CreaseTags& tags, int32_t v) {
  const absl::Span<const int32_t> ring = topology.Ring(v);
  const auto valence = static_cast<int32_t>(ring.size());
  Star star;
  star.triangles.resize(3, topology.IsBoundaryVertex(v) ? valence - 1 : valence);
  for (int32_t f = 0; f < star.triangles.cols(); ++f) {
    star.triangles.col(f) << 0, 1 + f, 1 + (f + 1) % valence;
  }
  for (const auto& [a, b] : tags.edges) {
    if (a != v && b != v) continue;
    const auto at = std::find(ring.begin(), ring.end(), a == v ? b : a);
    star.tags.edges.push_back({0, static_cast<int32_t>(1 + (at - ring.begin()))});
  }
  const bool corner = std::find(tags.corners.begin(), tags.corners.end(), v) != tags.corners.end();
  if (corner) star.tags.corners.push_back(0);
  return star;
}

}  // namespace

struct OpenSubdivLoop::Refiner {
  std::unique_ptr<Far::TopologyRefiner> far;
};

OpenSubdivLoop::OpenSubdivLoop(const Topology& topology, const CreaseTags& tags, int levels,
                               int depth)
    : refiner_(std::make_unique<Refiner>()) {
  refiner_->far = CreateRefiner(topology.vertex_count(), topology.triangles(), tags, depth);
  std::vector<int32_t>& first = numbers_.emplace_back(topology.vertex_count());
  for (int32_t v = 0; v < topology.vertex_count(); ++v) first[v] = v;
  Topology coarse = topology;
  for (int level = 0; level < levels; ++level) {
    const Far::TopologyLevel far = refiner_->far->GetLevel(level);
    std::vector<int32_t> finer;
    for (const int32_t v : numbers_[level]) finer.push_back(far.GetVertexChildVertex(v));
    for (int32_t e = 0; e < coarse.edge_count(); ++e) {
      const auto& [a, b] = coarse.edge(e);
      finer.push_back(far.GetEdgeChildVertex(far.FindEdge(numbers_[level][a], numbers_[level][b])));
    }
    coarse = *Topology::Create(static_cast<int32_t>(finer.size()), SplitTriangles(coarse));
    numbers_.push_back(std::move(finer));
  }
}

OpenSubdivLoop::~OpenSubdivLoop() = default;

Points3d OpenSubdivLoop::Refined(const Points3d& V, int level) const {
  const Points points = Refine(*refiner_->far, ToPoints(V), 0, level);
  Points3d refined(3, numbers_[level].size());
  for (int64_t v = 0; v < refined.cols(); ++v) refined.col(v) = points[numbers_[level][v]].p;
  return refined;
}

Points3d OpenSubdivLoop::Limit(const Points3d& V, int level) const {
  const Far::TopologyRefiner& far = *refiner_->far;
  const Points finest = Refine(far, ToPoints(V), 0, far.GetMaxLevel());
  Points at_limit(finest.size());
  Far::PrimvarRefinerReal<double>(far).Limit(finest, at_limit);
  Points3d limit(3, numbers_[level].size());
  for (int64_t v = 0; v < limit.cols(); ++v) {
    int32_t number = numbers_[level][v];
    for (int l = level; l < far.GetMaxLevel(); ++l) {
      number = far.GetLevel(l).GetVertexChildVertex(number);
    }
    limit.col(v) = at_limit[number].p;
  }
  return limit;
}

Points3d LimitByShrinkingStars(const Topology& topology, const CreaseTags& tags, const Points3d& V,
                               int rounds) {
  Points3d limit(3, topology.vertex_count());
  for (int32_t v = 0; v < topology.vertex_count(); ++v) {
    const Star star = StarOf(topology, tags, v);
    const absl::Span<const int32_t> ring = topology.Ring(v);
    const auto far =
        CreateRefiner(static_cast<int32_t>(1 + ring.size()), star.triangles, star.tags, 1);
    const Far::TopologyLevel level = far->GetLevel(0);
    Points points(1 + ring.size());
    points[0].p = V.col(v);
    for (size_t k = 0; k < ring.size(); ++k) points[1 + k].p = V.col(ring[k]);
    for (int round = 0; round < rounds; ++round) {
      const Points finer = Refine(*far, points, 0, 1);
      points[0] = finer[level.GetVertexChildVertex(0)];
      for (size_t k = 1; k < points.size(); ++k) {
        points[k] = finer[level.GetEdgeChildVertex(level.FindEdge(0, static_cast<int>(k)))];
      }
    }
    limit.col(v) = points[0].p;
  }
  return limit;
}

}  // namespace cagefit::testing
