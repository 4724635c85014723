#include "tests/core/subdiv/subdiv_samples.h"

#include <algorithm>
#include <random>
#include <utility>

#include "tests/support/shapes.h"

namespace cagefit::testing {

namespace {

SubdivSample Sample(std::string name, const TriangleMesh& mesh) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> uniform(-0.05, 0.05);
  Points3d V = mesh.vertices;
  for (int64_t k = 0; k < V.size(); ++k) V.data()[k] += uniform(random);
  return {std::move(name), std::move(V), TopologyOf(mesh), {}};
}

SubdivSample Tagged(std::string name, const TriangleMesh& mesh, CreaseTags tags) {
  SubdivSample sample = Sample(std::move(name), mesh);
  sample.tags = std::move(tags);
  return sample;
}

// The edges around vertex v: a closed crease.
CreaseTags CreaseAround(const Topology& topology, int32_t v) {
  const absl::Span<const int32_t> ring = topology.Ring(v);
  CreaseTags tags;
  for (size_t k = 0; k < ring.size(); ++k) {
    tags.edges.push_back({ring[k], ring[(k + 1) % ring.size()]});
  }
  return tags;
}

// One crease edge at the first vertex of each valence, in a place without sharp edges. Which of
// its edges differs, so that nothing rests on where the ring begins.
CreaseTags DartsOfAllValences(const Topology& topology) {
  CreaseTags tags;
  std::vector<char> taken(topology.vertex_count(), 0);
  for (int32_t valence = 3; valence <= 12; ++valence) {
    for (int32_t v = 0; v < topology.vertex_count(); ++v) {
      if (topology.Valence(v) != valence || taken[v]) continue;
      const absl::Span<const int32_t> ring = topology.Ring(v);
      const auto free = std::find_if(ring.begin() + valence / 2, ring.end(),
                                     [&](int32_t neighbor) { return !taken[neighbor]; });
      if (free == ring.end()) continue;
      tags.edges.push_back({*free, v});
      taken[v] = taken[*free] = 1;
      break;
    }
  }
  return tags;
}

}  // namespace

Topology TopologyOf(const TriangleMesh& mesh) {
  return *Topology::Create(static_cast<int32_t>(mesh.vertices.cols()), mesh.triangles);
}

std::vector<SubdivSample> SubdivSamples() {
  const TriangleMesh mixed = MixedValences(), grid = OpenGrid(5);
  const Topology mixed_topology = TopologyOf(mixed);
  std::vector<SubdivSample> samples;
  samples.push_back(Sample("MixedValences", mixed));
  samples.push_back(Sample("OpenGrid", grid));
  samples.push_back(Sample("OneCell", OpenGrid(1)));
  samples.push_back(Sample("OpenDisk", OpenDisk(4)));
  samples.push_back(Sample("Torus", Torus(9, 7)));
  samples.push_back(Sample("Tube", Tube(8, 5)));
  samples.push_back(Tagged("ClosedCrease", mixed, CreaseAround(mixed_topology, 40)));
  samples.push_back(Tagged("Darts", mixed, DartsOfAllValences(mixed_topology)));
  // Six vertices a row: 6 lies on the boundary, 7 to 10 inside, 14 above 8. The first crease makes
  // a corner of 6 and ends in a dart at 9.
  samples.push_back(Tagged("CreaseFromTheBoundary", grid, {{{6, 7}, {7, 8}, {9, 8}}, {}}));
  samples.push_back(Tagged("ThreeCreasesMeet", grid, {{{7, 8}, {9, 8}, {8, 14}}, {}}));
  samples.push_back(Tagged("Corners", grid, {{}, {0, 5, 21, 30, 35}}));
  samples.push_back(Tagged("TwoSharpEdgesOfACorner", grid, {{{13, 14}, {14, 15}}, {14}}));
  return samples;
}

std::vector<int32_t> Darts(const Topology& topology, const CreaseTags& tags) {
  const SharpFeatures sharp = FindSharpFeatures(topology, tags);
  std::vector<int32_t> darts;
  for (int32_t v = 0; v < topology.vertex_count(); ++v) {
    const absl::Span<const int32_t> edges = topology.RingEdges(v);
    const auto sharp_edges = std::count_if(edges.begin(), edges.end(),
                                           [&](int32_t e) { return sharp.sharp_edge[e] != 0; });
    if (sharp_edges == 1 && sharp.vertex_rule[v] == VertexRule::kSmooth) darts.push_back(v);
  }
  return darts;
}

}  // namespace cagefit::testing
