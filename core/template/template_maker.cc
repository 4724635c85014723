#include "core/template/template_maker.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <utility>
#include <vector>

#include "absl/strings/str_format.h"
#include "core/base/status.h"
#include "core/mesh/crease_detection.h"
#include "core/mesh/triangle_quality.h"
#include "core/subdiv/limit.h"
#include "core/template/carry_tags.h"
#include "core/template/edge_split.h"
#include "core/template/fine_surface.h"
#include "core/template/mesh_relax.h"
#include "core/template/mesh_repair.h"
#include "core/template/needle_removal.h"
#include "core/template/poisson.h"
#include "core/template/quadric_collapse.h"

namespace cagefit {

namespace {

constexpr int32_t kMinVertices = 4, kMaxVertices = 1'000'000;
constexpr double kComponentShare = 0.01;  // of the largest component's area
constexpr double kCountTolerance = 0.01;
constexpr int kRelaxRounds = 5;
constexpr int kNeedleRounds = 3;
constexpr double kNeedleQuality = 0.3;
constexpr int kMaxRetries = 5;
constexpr int kInflateRounds = 4;
constexpr int kMostHalvings = 6;
constexpr double kInflateQuality = 0.2, kInflateCosine = 0.5;  // what inflation leaves

// Splits every triangle in four, and every crease in two, at the edges' middles.
absl::StatusOr<TaggedMesh> SplitEdges(const TaggedMesh& coarse) {
  const Points3d& V = coarse.mesh.vertices;
  const int32_t n = static_cast<int32_t>(V.cols());
  ASSIGN_OR_RETURN(const Topology topology, Topology::Create(n, coarse.mesh.triangles));
  TaggedMesh fine;
  fine.mesh.vertices.resize(3, n + topology.edge_count());
  fine.mesh.vertices.leftCols(n) = V;
  for (int32_t e = 0; e < topology.edge_count(); ++e) {
    const auto& [a, b] = topology.edge(e);
    fine.mesh.vertices.col(n + e) = 0.5 * (V.col(a) + V.col(b));
  }
  Triangles& T = fine.mesh.triangles;
  T.resize(3, 4 * topology.triangle_count());
  for (int32_t f = 0; f < topology.triangle_count(); ++f) {
    const auto t = topology.triangles().col(f);
    const int32_t m[3] = {n + topology.triangle_edge(f, 0), n + topology.triangle_edge(f, 1),
                          n + topology.triangle_edge(f, 2)};
    T.col(4 * f) << t[0], m[0], m[2];
    T.col(4 * f + 1) << t[1], m[1], m[0];
    T.col(4 * f + 2) << t[2], m[2], m[1];
    T.col(4 * f + 3) << m[0], m[1], m[2];
  }
  for (const auto& [a, b] : coarse.tags.edges) {
    const int32_t middle = n + topology.FindEdge(a, b);
    fine.tags.edges.push_back({a, middle});
    fine.tags.edges.push_back({middle, b});
  }
  fine.tags.corners = coarse.tags.corners;
  return fine;
}

// Puts the creases of a repaired mesh into its tags: those given for `input`, or those found.
absl::Status TagCreases(const TriangleMesh& input, const TemplateOptions& options,
                        TaggedMesh* clean) {
  const bool given = !options.tags.edges.empty() || !options.tags.corners.empty();
  if (!given) FlipCaps(&clean->mesh);
  const Points3d& V = clean->mesh.vertices;
  ASSIGN_OR_RETURN(const Topology topology,
                   Topology::Create(static_cast<int32_t>(V.cols()), clean->mesh.triangles));
  if (given) {
    ASSIGN_OR_RETURN(clean->tags, CarryTags(options.tags, input.vertices, V, topology));
  } else {
    const std::optional<double>& angle = options.crease_angle;
    clean->tags = DetectCreases(V, topology, angle.value_or(kDefaultCreaseAngle),
                                angle.has_value() ? CreaseEffort::kAlways : CreaseEffort::kOnParts);
  }
  return absl::OkStatus();
}

// A manifold mesh with enough vertices to collapse to the count asked for, and its creases.
absl::StatusOr<TaggedMesh> Prepare(const TriangleMesh& mesh, const TemplateOptions& options,
                                   TemplateReport* report) {
  RepairReport repair;
  TaggedMesh clean = {MakeManifold(mesh, &repair), {}};
  report->repaired_triangles = repair.dropped_triangles;
  report->repaired_vertices = repair.split_vertices;
  if (clean.mesh.triangles.cols() == 0) {
    return absl::FailedPreconditionError(
        "template: no triangle is left after repair (all degenerate or none given)");
  }
  clean.mesh = KeepLargeComponents(clean.mesh, kComponentShare, &report->components_kept,
                                   &report->components_dropped);
  RETURN_IF_ERROR(TagCreases(mesh, options, &clean));
  while (clean.mesh.vertices.cols() < options.vertices) {
    ASSIGN_OR_RETURN(clean, SplitEdges(clean));
  }
  return clean;
}

TaggedMesh Reduce(const TaggedMesh& fine, const FineSurface& surface, int32_t vertices) {
  TaggedMesh coarse = CollapseEdges(fine, vertices);
  // Needles of the input may block each other; better triangles free them.
  for (int k = 0; k < kMaxRetries && coarse.mesh.vertices.cols() > vertices; ++k) {
    RelaxMesh(surface, 1, &coarse);
    coarse = CollapseEdges(coarse, vertices);
  }
  RelaxMesh(surface, kRelaxRounds, &coarse);
  // What goes with the needles comes back where edges are long.
  for (int round = 0; round < kNeedleRounds; ++round) {
    const int64_t before = coarse.mesh.vertices.cols();
    RemoveNeedles(surface, kNeedleQuality, &coarse);
    if (coarse.mesh.vertices.cols() < before) {
      SplitLongEdges(surface, std::min<int64_t>(before, vertices), &coarse);
    }
    RelaxMesh(surface, 2, &coarse);
  }
  return coarse;
}

bool HasCount(const TaggedMesh& mesh, int32_t vertices) {
  const double difference = std::abs(static_cast<double>(mesh.mesh.vertices.cols()) - vertices);
  return difference <= kCountTolerance * vertices;
}

// Vertices V + s D, every one with its own s, 1 where no triangle turns over or becomes a needle
// and as much less as that takes elsewhere.
Points3d MovedSafely(const ControlMesh& cage, const Points3d& D) {
  const Points3d& V = cage.vertices();
  const Triangles& T = cage.triangles();
  // Sharp curves come last: nothing but their own vertices holds them in place.
  std::vector<char> curve(V.cols(), 0);
  for (const auto& edge : cage.tags().edges) {
    for (const int32_t v : edge) curve[v] = 1;
  }
  Eigen::ArrayXd s = Eigen::ArrayXd::Ones(V.cols());
  Points3d moved = V + D;
  const auto cross = [&](const Points3d& P, int64_t f) -> Eigen::Vector3d {
    return (P.col(T(1, f)) - P.col(T(0, f))).cross(P.col(T(2, f)) - P.col(T(0, f)));
  };
  const auto quality = [&](const Points3d& P, int64_t f) {
    return TriangleQuality(P.col(T(0, f)), P.col(T(1, f)), P.col(T(2, f)));
  };
  for (int round = 0; round < kMostHalvings; ++round) {
    std::vector<char> halve(V.cols(), 0);
    bool any = false;
    for (int64_t f = 0; f < T.cols(); ++f) {
      const Eigen::Vector3d before = cross(V, f), after = cross(moved, f);
      if (after.dot(before) > kInflateCosine * after.norm() * before.norm() &&
          quality(moved, f) >= std::min(kInflateQuality, quality(V, f))) {
        continue;
      }
      for (int c = 0; c < 3; ++c) halve[T(c, f)] = !curve[T(c, f)] || round >= kMostHalvings / 2;
      any = true;
    }
    if (!any) return moved;
    for (int64_t v = 0; v < V.cols(); ++v) {
      if (!halve[v]) continue;
      s[v] = round + 1 < kMostHalvings ? 0.5 * s[v] : 0;
      moved.col(v) = V.col(v) + s[v] * D.col(v);
    }
  }
  return moved;
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
  return MovedSafely(cage, V - cage.vertices());
}

}  // namespace

absl::Status TemplateOptions::Validate() const {
  if (!(vertices >= kMinVertices && vertices <= kMaxVertices)) {
    return absl::InvalidArgumentError(absl::StrFormat("vertices is %d; it must be from %d to %d",
                                                      vertices, kMinVertices, kMaxVertices));
  }
  if (crease_angle.has_value() && !(*crease_angle >= 0 && *crease_angle <= 180)) {
    return absl::InvalidArgumentError(
        absl::StrFormat("crease_angle is %g; it must be from 0 to 180 degrees", *crease_angle));
  }
  return absl::OkStatus();
}

absl::StatusOr<ControlMesh> TemplateFromMesh(const TriangleMesh& mesh,
                                             const TemplateOptions& options,
                                             TemplateReport* report) {
  RETURN_IF_ERROR(options.Validate());
  report->input_vertices = mesh.vertices.cols();
  ASSIGN_OR_RETURN(TaggedMesh fine, Prepare(mesh, options, report));
  const FineSurface surface(fine);
  TaggedMesh coarse = Reduce(fine, surface, options.vertices);
  if (!HasCount(coarse, options.vertices) && !fine.tags.edges.empty()) {
    fine.tags = {};
    coarse = Reduce(fine, surface, options.vertices);
  }
  if (!HasCount(coarse, options.vertices)) {
    return absl::FailedPreconditionError(
        absl::StrFormat("template: edge collapse stopped at %d vertices where %d were asked for; "
                        "the topology of the "
                        "surface needs more",
                        coarse.mesh.vertices.cols(), options.vertices));
  }
  absl::StatusOr<ControlMesh> cage = ControlMesh::Create(
      std::move(coarse.mesh.vertices), std::move(coarse.mesh.triangles), std::move(coarse.tags));
  if (!cage.ok()) {
    return absl::FailedPreconditionError(
        absl::StrFormat("template: the collapsed mesh is not valid: %s", cage.status().message()));
  }
  report->crease_edges = static_cast<int32_t>(cage->tags().edges.size());
  report->corners = static_cast<int32_t>(cage->tags().corners.size());
  report->boundary_loops = static_cast<int32_t>(cage->topology().BoundaryLoops().size());
  return cage->WithVertices(Inflate(*cage));
}

absl::StatusOr<ControlMesh> TemplateFromCloud(const PointCloud& cloud,
                                              const TemplateOptions& options,
                                              TemplateReport* report) {
  RETURN_IF_ERROR(options.Validate());
  RETURN_IF_ERROR(ValidateTarget(cloud));
  ASSIGN_OR_RETURN(const TriangleMesh surface, ReconstructPoisson(cloud, options.vertices));
  TemplateOptions smooth = options;  // Poisson rounds every edge; what is sharp there is noise
  smooth.tags = {};
  smooth.crease_angle = 0;
  absl::StatusOr<ControlMesh> cage = TemplateFromMesh(surface, smooth, report);
  report->input_vertices = cloud.size();
  return cage;
}

}  // namespace cagefit
