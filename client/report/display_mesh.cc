#include "client/report/display_mesh.h"

#include <utility>

#include "core/subdiv/refine.h"
#include "core/subdiv/shaded_mesh.h"

namespace cagefit::client {
namespace {

constexpr int kMostLevels = 3;

// The control mesh's connectivity, refined.
struct Level {
  int number = 0;
  Topology topology;
  CreaseTags tags;
};

int64_t RefinedVertices(const Topology& topology) {
  return int64_t{topology.vertex_count()} + topology.edge_count();
}

Level Refine(const ControlMesh& cage, int64_t most_vertices) {
  Level level{0, cage.topology(), cage.tags()};
  while (level.number < kMostLevels && RefinedVertices(level.topology) <= most_vertices) {
    Refinement finer = RefineOnce(level.topology, level.tags);
    level = {level.number + 1, std::move(finer.topology), std::move(finer.tags)};
  }
  return level;
}

}  // namespace

DisplayMesh BuildDisplayMesh(const ControlMesh& cage, int64_t most_vertices) {
  const Level level = Refine(cage, most_vertices);
  const ShadedMesh shaded(cage, level.number);
  DisplayMesh mesh;
  mesh.levels = level.number;
  mesh.position = BuildLimitMesh(cage.topology(), cage.tags(), level.number).position;
  mesh.limit_triangles = shaded.limit_triangles();
  mesh.triangles = shaded.triangles();
  mesh.limit_vertices = shaded.limit_vertices();
  mesh.creases = level.tags.edges;
  for (int32_t e = 0; e < level.topology.edge_count(); ++e) {
    if (level.topology.IsBoundaryEdge(e)) mesh.borders.push_back(level.topology.edge(e));
  }
  return mesh;
}

}  // namespace cagefit::client
