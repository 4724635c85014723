#include "core/template/template_maker.h"

#include <cmath>
#include <cstdlib>
#include <utility>

#include "absl/strings/str_format.h"
#include "core/base/status.h"
#include "core/mesh/triangle_bvh.h"
#include "core/subdiv/limit.h"
#include "core/template/mesh_relax.h"
#include "core/template/mesh_repair.h"
#include "core/template/poisson.h"
#include "core/template/quadric_collapse.h"

namespace cagefit {

namespace {

constexpr int32_t kMinVertices = 4, kMaxVertices = 1'000'000;
constexpr double kComponentShare = 0.01;  // of the largest component's area
constexpr double kCountTolerance = 0.01;
constexpr int kRelaxRounds = 5;
constexpr int kMaxRetries = 5;
constexpr int kInflateRounds = 4;

// Splits every triangle in four at its edges' middles.
absl::StatusOr<TriangleMesh> SplitEdges(const TriangleMesh& mesh) {
  const int32_t n = static_cast<int32_t>(mesh.vertices.cols());
  ASSIGN_OR_RETURN(const Topology topology, Topology::Create(n, mesh.triangles));
  TriangleMesh fine;
  fine.vertices.resize(3, n + topology.edge_count());
  fine.vertices.leftCols(n) = mesh.vertices;
  for (int32_t e = 0; e < topology.edge_count(); ++e) {
    const auto& [a, b] = topology.edge(e);
    fine.vertices.col(n + e) = 0.5 * (mesh.vertices.col(a) + mesh.vertices.col(b));
  }
  fine.triangles.resize(3, 4 * mesh.triangles.cols());
  for (int32_t f = 0; f < topology.triangle_count(); ++f) {
    const auto t = mesh.triangles.col(f);
    const int32_t m[3] = {n + topology.triangle_edge(f, 0), n + topology.triangle_edge(f, 1),
                          n + topology.triangle_edge(f, 2)};
    fine.triangles.col(4 * f) << t[0], m[0], m[2];
    fine.triangles.col(4 * f + 1) << t[1], m[1], m[0];
    fine.triangles.col(4 * f + 2) << t[2], m[2], m[1];
    fine.triangles.col(4 * f + 3) << m[0], m[1], m[2];
  }
  return fine;
}

// A manifold mesh with enough vertices to collapse to the count asked for.
absl::StatusOr<TriangleMesh> Prepare(const TriangleMesh& mesh, int32_t vertices,
                                     TemplateReport* report) {
  RepairReport repair;
  TriangleMesh clean = MakeManifold(mesh, &repair);
  report->repaired_triangles = repair.dropped_triangles;
  report->repaired_vertices = repair.split_vertices;
  if (clean.triangles.cols() == 0) {
    return absl::FailedPreconditionError(
        "template: no triangle is left after repair (all degenerate or none given)");
  }
  clean = KeepLargeComponents(clean, kComponentShare, &report->components_kept,
                              &report->components_dropped);
  while (clean.vertices.cols() < vertices) {
    ASSIGN_OR_RETURN(clean, SplitEdges(clean));
  }
  return clean;
}

// Moves the control vertices until the limit surface, which lies inside the control mesh where that
// bulges, passes near where they were: V <- V + (V0 - L V) [cheng2009]. More rounds interpolate,
// and ripple.
Points3d Inflate(const ControlMesh& cage) {
  const StencilMatrix limit = LimitPositionStencils(cage.topology(), cage.tags());
  Points3d V = cage.vertices(), at_limit;
  for (int round = 0; round < kInflateRounds; ++round) {
    ApplyStencils(limit, V, &at_limit);
    V += cage.vertices() - at_limit;
  }
  return V;
}

}  // namespace

absl::Status TemplateOptions::Validate() const {
  if (vertices >= kMinVertices && vertices <= kMaxVertices) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrFormat("vertices is %d; it must be from %d to %d",
                                                    vertices, kMinVertices, kMaxVertices));
}

absl::StatusOr<ControlMesh> TemplateFromMesh(const TriangleMesh& mesh,
                                             const TemplateOptions& options,
                                             TemplateReport* report) {
  RETURN_IF_ERROR(options.Validate());
  report->input_vertices = mesh.vertices.cols();
  ASSIGN_OR_RETURN(const TriangleMesh fine, Prepare(mesh, options.vertices, report));
  const TriangleBvh surface(fine.vertices, fine.triangles);
  TriangleMesh coarse = CollapseEdges(fine, options.vertices);
  // Needles of the input may block each other; better triangles free them.
  for (int k = 0; k < kMaxRetries && coarse.vertices.cols() > options.vertices; ++k) {
    RelaxMesh(surface, 1, &coarse);
    coarse = CollapseEdges(coarse, options.vertices);
  }
  RelaxMesh(surface, kRelaxRounds, &coarse);
  const double difference =
      std::abs(static_cast<double>(coarse.vertices.cols()) - options.vertices);
  if (difference > kCountTolerance * options.vertices) {
    return absl::FailedPreconditionError(
        absl::StrFormat("template: edge collapse stopped at %d vertices where %d were asked for; "
                        "the topology of the "
                        "surface needs more",
                        coarse.vertices.cols(), options.vertices));
  }
  absl::StatusOr<ControlMesh> cage =
      ControlMesh::Create(std::move(coarse.vertices), std::move(coarse.triangles));
  if (!cage.ok()) {
    return absl::FailedPreconditionError(
        absl::StrFormat("template: the collapsed mesh is not valid: %s", cage.status().message()));
  }
  report->boundary_loops = static_cast<int32_t>(cage->topology().BoundaryLoops().size());
  return cage->WithVertices(Inflate(*cage));
}

absl::StatusOr<ControlMesh> TemplateFromCloud(const PointCloud& cloud,
                                              const TemplateOptions& options,
                                              TemplateReport* report) {
  RETURN_IF_ERROR(options.Validate());
  RETURN_IF_ERROR(ValidateTarget(cloud));
  ASSIGN_OR_RETURN(const TriangleMesh surface, ReconstructPoisson(cloud, options.vertices));
  absl::StatusOr<ControlMesh> cage = TemplateFromMesh(surface, options, report);
  report->input_vertices = cloud.size();
  return cage;
}

}  // namespace cagefit
