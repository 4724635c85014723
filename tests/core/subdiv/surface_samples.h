// Surfaces for the tests of LimitSurface, and their points.
#ifndef CAGEFIT_TESTS_CORE_SUBDIV_SURFACE_SAMPLES_H_
#define CAGEFIT_TESTS_CORE_SUBDIV_SURFACE_SAMPLES_H_

#include <vector>

#include "core/subdiv/surface_point.h"
#include "tests/core/subdiv/subdiv_samples.h"

namespace cagefit::testing {

// Six of the data's models, one (fandisk) with creases where it bends by more than 30 degrees.
std::vector<SubdivSample> SurfaceModels();

// TouchingHubs (tests/support/shapes.h).
SubdivSample Hubs();

// Edges whose triangles' planes differ by more than `degrees`.
CreaseTags SharpEdges(const Topology& topology, const Points3d& V, double degrees);

// Uniform in (face, u, v).
std::vector<SurfacePoint> RandomSurfacePoints(const Topology& topology, int count, unsigned seed);

// Where corner c of a triangle is.
SurfacePoint Corner(int32_t face, int c);

// LimitSurface at the points.
std::vector<SurfaceJet> Ours(const SubdivSample& sample, const std::vector<SurfacePoint>& points,
                             Derivatives derivatives);

// Between the normals du x dv, in radians.
double Angle(const SurfaceJet& a, const SurfaceJet& b);

}  // namespace cagefit::testing

#endif  // CAGEFIT_TESTS_CORE_SUBDIV_SURFACE_SAMPLES_H_
