#include "core/energy/landmark_term.h"

#include <gtest/gtest.h>

#include <limits>
#include <string>

#include "core/subdiv/limit_surface.h"
#include "tests/core/subdiv/subdiv_samples.h"
#include "tests/support/shapes.h"

namespace cagefit {
namespace {

struct Term {
  Term()
      : mesh(testing::MixedValences()), topology(testing::TopologyOf(mesh)), term(topology, {}) {}
  TriangleMesh mesh;
  Topology topology;
  LandmarkTerm term;
};

TEST(LandmarkTermTest, EnergyIsTheWeightedMeanSquareTimesTheVertices) {
  Term t;
  const SurfacePoint at = {3, 0.25, 0.5};
  const Eigen::Vector3d p(0.4, -1, 2), q(3, 2, 1);
  t.term.SetTarget({{5, {}, p}, {-1, at, q}}, 0.7);
  const LimitSurface surface(t.topology, {});
  Points3d control_points;
  surface.ControlPoints(t.mesh.vertices, &control_points);
  const Eigen::Vector3d X = surface.Evaluate(control_points, at, Derivatives::kNone).position;
  const double squares = (t.mesh.vertices.col(5) - p).squaredNorm() + (X - q).squaredNorm();
  EXPECT_NEAR(t.term.attachments().Energy(t.mesh.vertices),
              0.7 * t.topology.vertex_count() / 2 * squares, 1e-9);
}

TEST(LandmarkTermTest, FollowsPlacesAndPositionsOfEveryFrame) {
  Term t;
  const Eigen::Vector3d zero = Eigen::Vector3d::Zero();
  const auto energy_of = [&](const std::vector<Landmark>& landmarks) {
    t.term.SetTarget(landmarks, 1);
    return t.term.attachments().Energy(t.mesh.vertices) / t.topology.vertex_count();
  };
  EXPECT_NEAR(energy_of({{2, {}, zero}}), t.mesh.vertices.col(2).squaredNorm(), 1e-12);
  EXPECT_NEAR(energy_of({{2, {}, t.mesh.vertices.col(2)}}), 0, 1e-12);
  EXPECT_NEAR(energy_of({{1, {}, zero}}), t.mesh.vertices.col(1).squaredNorm(), 1e-12);
  EXPECT_EQ(energy_of({}), 0);
  EXPECT_NEAR(energy_of({{1, {}, zero}}), t.mesh.vertices.col(1).squaredNorm(), 1e-12);
  t.term.SetTarget({{1, {}, zero}}, 0);
  EXPECT_EQ(t.term.attachments().size(), 0);
}

TEST(LandmarkTermTest, BadOnesAreNamed) {
  const auto message_of = [](const Landmark& bad) {
    const absl::Status status = CheckLandmarks({{0, {}, {0, 0, 0}}, bad}, 10, 20);
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
    return std::string(status.message());
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(message_of({10, {}, {0, 0, 0}}), "landmarks[1].vertex is 10; the mesh has 10 vertices");
  EXPECT_EQ(message_of({-1, {20, 0, 0}, {0, 0, 0}}),
            "landmarks[1].triangle is 20; the mesh has 20 triangles");
  EXPECT_EQ(message_of({-1, {-1, 0, 0}, {0, 0, 0}}),
            "landmarks[1].triangle is -1; the mesh has 20 triangles");
  EXPECT_EQ(message_of({-1, {3, 0.6, 0.5}, {0, 0, 0}}),
            "landmarks[1].surface is (0.6, 0.5); outside the triangle");
  EXPECT_EQ(message_of({-1, {3, nan, 0}, {0, 0, 0}}),
            "landmarks[1].surface is (nan, 0); outside the triangle");
  EXPECT_EQ(message_of({1, {}, {0, nan, 0}}), "landmarks[1].position is not finite");
  EXPECT_TRUE(CheckLandmarks({{9, {}, {0, 0, 0}}, {-1, {19, 0.5, 0.5}, {1, 2, 3}}}, 10, 20).ok());
}

}  // namespace
}  // namespace cagefit
