#include "tests/core/subdiv/surface_samples.h"

#include <Eigen/Geometry>
#include <cmath>
#include <random>

#include "core/subdiv/limit_surface.h"
#include "tests/support/mesh_file.h"
#include "tests/support/shapes.h"

namespace cagefit::testing {

std::vector<SubdivSample> SurfaceModels() {
  std::vector<SubdivSample> models;
  for (const char* name :
       {"control/bunny_314.obj", "control/spot_829.obj", "static/torus_2304.ply",
        "static/fandisk_6475.ply", "static/hemisphere_1861.ply", "static/face_25905.ply"}) {
    const TriangleMesh mesh = ReadTestMesh(name);
    models.push_back({name, mesh.vertices, TopologyOf(mesh), {}});
  }
  SubdivSample& fandisk = models[3];
  fandisk.tags = SharpEdges(fandisk.topology, fandisk.V, 30);
  return models;
}

SubdivSample Hubs() {
  const TriangleMesh mesh = TouchingHubs();
  return {"TouchingHubs", mesh.vertices, TopologyOf(mesh), {}};
}

CreaseTags SharpEdges(const Topology& topology, const Points3d& V, double degrees) {
  const auto normal = [&](int32_t f) {
    const auto t = topology.triangles().col(f);
    const Eigen::Vector3d ab = V.col(t(1)) - V.col(t(0)), ac = V.col(t(2)) - V.col(t(0));
    return ab.cross(ac).normalized();
  };
  CreaseTags tags;
  for (int32_t e = 0; e < topology.edge_count(); ++e) {
    const auto& [f, g] = topology.edge_triangles(e);
    if (g == Topology::kNone) continue;
    if (normal(f).dot(normal(g)) < std::cos(degrees * 3.14159265358979323846 / 180)) {
      tags.edges.push_back(topology.edge(e));
    }
  }
  return tags;
}

std::vector<SurfacePoint> RandomSurfacePoints(const Topology& topology, int count, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(0, 1);
  std::vector<SurfacePoint> points;
  for (int k = 0; k < count; ++k) {
    double u = unit(random), v = unit(random);
    if (u + v > 1) u = 1 - u, v = 1 - v;
    points.push_back({static_cast<int32_t>(random() % topology.triangle_count()), u, v});
  }
  return points;
}

SurfacePoint Corner(int32_t face, int c) { return {face, c == 1 ? 1.0 : 0.0, c == 2 ? 1.0 : 0.0}; }

std::vector<SurfaceJet> Ours(const SubdivSample& sample, const std::vector<SurfacePoint>& points,
                             Derivatives derivatives) {
  const LimitSurface surface(sample.topology, sample.tags);
  Points3d control_points;
  surface.ControlPoints(sample.V, &control_points);
  std::vector<SurfaceJet> jets;
  for (const SurfacePoint& point : points) {
    jets.push_back(surface.Evaluate(control_points, point, derivatives));
  }
  return jets;
}

double Angle(const SurfaceJet& a, const SurfaceJet& b) {
  const Eigen::Vector3d n = a.du.cross(a.dv).normalized(), m = b.du.cross(b.dv).normalized();
  return std::atan2(n.cross(m).norm(), n.dot(m));
}

}  // namespace cagefit::testing
