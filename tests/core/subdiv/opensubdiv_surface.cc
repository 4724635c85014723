#include "tests/core/subdiv/opensubdiv_surface.h"

#include <opensubdiv/bfr/refinerSurfaceFactory.h>
#include <opensubdiv/bfr/surface.h>

#include <stdexcept>

#include "tests/core/subdiv/opensubdiv_mesh.h"

namespace cagefit::testing {

std::vector<SurfaceJet> OpenSubdivSurface(const Topology& topology, const CreaseTags& tags,
                                          const Points3d& V,
                                          const std::vector<SurfacePoint>& points, int depth) {
  namespace Bfr = OpenSubdiv::Bfr;
  const auto mesh = OpenSubdivMesh(topology.vertex_count(), topology.triangles(), tags);
  Bfr::SurfaceFactory::Options options;
  options.SetApproxLevelSmooth(depth).SetApproxLevelSharp(depth);
  const Bfr::RefinerSurfaceFactory<> factory(*mesh, options);
  Bfr::Surface<double> surface;
  const Bfr::Surface<double>::PointDescriptor layout(3);
  std::vector<double> patch;
  std::vector<SurfaceJet> jets;
  int32_t face = -1;
  for (const SurfacePoint& point : points) {
    if (point.face != face) {
      face = point.face;
      if (!factory.InitVertexSurface(face, &surface)) throw std::runtime_error("no surface");
      patch.resize(3 * static_cast<size_t>(surface.GetNumPatchPoints()));
      surface.PreparePatchPoints(V.data(), layout, patch.data(), layout);
    }
    const double uv[2] = {point.u, point.v};
    SurfaceJet jet;
    surface.Evaluate(uv, patch.data(), layout, jet.position.data(), jet.du.data(), jet.dv.data(),
                     jet.duu.data(), jet.duv.data(), jet.dvv.data());
    jets.push_back(jet);
  }
  return jets;
}

}  // namespace cagefit::testing
