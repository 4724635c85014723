#include "tests/core/subdiv/opensubdiv_mesh.h"

#include <opensubdiv/far/topologyDescriptor.h>
#include <opensubdiv/far/topologyRefinerFactory.h>

#include <algorithm>
#include <vector>

namespace cagefit::testing {

namespace Far = OpenSubdiv::Far;
namespace Sdc = OpenSubdiv::Sdc;

std::unique_ptr<Far::TopologyRefiner> OpenSubdivMesh(int32_t vertex_count,
                                                     const Triangles& triangles,
                                                     const CreaseTags& tags) {
  const std::vector<int> sizes(triangles.cols(), 3);
  const std::vector<float> sharp(std::max(tags.edges.size(), tags.corners.size()),
                                 Sdc::Crease::SHARPNESS_INFINITE);
  Far::TopologyDescriptor mesh;
  mesh.numVertices = vertex_count;
  mesh.numFaces = static_cast<int>(triangles.cols());
  mesh.numVertsPerFace = sizes.data();
  mesh.vertIndicesPerFace = triangles.data();
  mesh.numCreases = static_cast<int>(tags.edges.size());
  mesh.creaseVertexIndexPairs = tags.edges.empty() ? nullptr : tags.edges.front().data();
  mesh.creaseWeights = sharp.data();
  mesh.numCorners = static_cast<int>(tags.corners.size());
  mesh.cornerVertexIndices = tags.corners.data();
  mesh.cornerWeights = sharp.data();
  Sdc::Options scheme;
  scheme.SetVtxBoundaryInterpolation(Sdc::Options::VTX_BOUNDARY_EDGE_ONLY);
  using Factory = Far::TopologyRefinerFactory<Far::TopologyDescriptor>;
  return std::unique_ptr<Far::TopologyRefiner>(
      Factory::Create(mesh, Factory::Options(Sdc::SCHEME_LOOP, scheme)));
}

}  // namespace cagefit::testing
