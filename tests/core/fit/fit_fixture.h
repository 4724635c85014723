// A small fitting problem with a known answer: an icosphere cage and a cloud on an ellipsoid.
#ifndef CAGEFIT_TESTS_CORE_FIT_FIT_FIXTURE_H_
#define CAGEFIT_TESTS_CORE_FIT_FIT_FIXTURE_H_

#include <cmath>
#include <memory>
#include <utility>

#include "core/cloud/target_index.h"
#include "core/fit/objective.h"
#include "core/mesh/control_mesh.h"
#include "core/subdiv/limit.h"
#include "tests/support/shapes.h"

namespace cagefit::testing {

// An even cloud with exact normals on the ellipsoid with half axes `a`.
inline PointCloud EllipsoidCloud(int64_t count, const Eigen::Vector3d& a) {
  PointCloud cloud;
  cloud.points.resize(3, count);
  cloud.normals.resize(3, count);
  for (int64_t i = 0; i < count; ++i) {
    const double z = 1 - (2.0 * static_cast<double>(i) + 1) / static_cast<double>(count);
    const double turn = 2.399963229728653 * static_cast<double>(i);
    const double r = std::sqrt(1 - z * z);
    const Eigen::Vector3d n(r * std::cos(turn), r * std::sin(turn), z);
    cloud.points.col(i) = a.cwiseProduct(n).cast<float>();
    cloud.normals.col(i) = n.cwiseQuotient(a).normalized().cast<float>();
  }
  return cloud;
}

inline ControlMesh SphereCage(int levels, double radius) {
  TriangleMesh mesh = Icosphere(levels, radius);
  return *ControlMesh::Create(std::move(mesh.vertices), std::move(mesh.triangles));
}

// Landmarks and boundaries act once they are set as targets.
inline OptionalTerms TermsFor(const ControlMesh& cage, double coverage_weight) {
  OptionalTerms terms;
  if (coverage_weight > 0) {
    terms.coverage = std::make_unique<CoverageTerm>(cage.topology(), cage.tags());
  }
  terms.landmarks = std::make_unique<LandmarkTerm>(cage.topology(), cage.tags());
  terms.boundary = std::make_unique<BoundaryTerm>(cage.topology(), cage.tags());
  return terms;
}

// Objective over a cage, an icosphere unless given, against a cloud, an ellipsoid's unless given;
// unit coordinates, fixed radius.
struct FitProblem {
  explicit FitProblem(double arap_weight, double radius = 0.08, double coverage_weight = 0)
      : FitProblem(SphereCage(2, 0.45), EllipsoidCloud(8000, {0.5, 0.4, 0.3}), arap_weight, radius,
                   coverage_weight) {}
  FitProblem(const ControlMesh& start, PointCloud target_cloud, double arap_weight, double radius,
             double coverage_weight)
      : cage(start),
        cloud(std::move(target_cloud)),
        objective(cage.topology(), BuildLimitMesh(cage.topology(), cage.tags(), 1).position,
                  arap_weight, TermsFor(cage, coverage_weight)) {
    (void)index.Build(cloud, radius, 2);
    target.index = &index;
    target.far_radius = 3 * radius;
    target.covered = &cloud;
    target.coverage_weight = coverage_weight;
    objective.SetTarget(target);
    objective.SetRest(cage.vertices());
  }
  ControlMesh cage;
  PointCloud cloud;
  TargetIndex index;
  ObjectiveTarget target;
  Objective objective;
};

}  // namespace cagefit::testing

#endif  // CAGEFIT_TESTS_CORE_FIT_FIT_FIXTURE_H_
