#include "server/session/surface_model.h"

#include <gtest/gtest.h>

#include "tests/server/session/session_fixture.h"

namespace cagefit::server {
namespace {

using cagefit::testing::FrameCage;
using cagefit::testing::SphereCloud;
using testing::CageConfig;

// Points of the very mesh that a verdict measures against.
PointCloud LimitCloud(const ControlMesh& cage) {
  const LimitMesh limit = BuildLimitMesh(cage.topology(), cage.tags(), 1);
  TriangleMesh mesh;
  ApplyStencils(limit.position, cage.vertices(), &mesh.vertices);
  mesh.triangles = limit.triangles;
  return CloudFromMesh(mesh);
}

class SurfaceModelTest : public ::testing::Test {
 protected:
  SurfaceModelTest()
      : cloud_(LimitCloud(cage_)),
        diagonal_(BoundingBox(cloud_.points).diagonal()),
        model_(SurfaceModel::Create(cage_, BoundingBox(cloud_.points), CageConfig()).value()) {}

  Judgement JudgeMoved(double share_of_diagonal, double median_rms = 0, double h = 0) {
    Points3d vertices = cage_.vertices();
    vertices.row(0).array() += share_of_diagonal * diagonal_;
    VerdictInput known;
    known.median_rms = median_rms;
    return model_.Judge(cloud_, vertices, known, h);
  }

  const ControlMesh cage_ = FrameCage(2);
  const PointCloud cloud_;
  const double diagonal_;
  SurfaceModel model_;
};

TEST_F(SurfaceModelTest, TheGridIsTheFirstTargets) {
  PointCloud cloud = SphereCloud(500, {0, 0, 0});
  cloud.points.row(0).array() += 5;
  SessionConfig config = CageConfig();
  config.quantum = 1e-4;
  const auto model = SurfaceModel::Create(FrameCage(), BoundingBox(cloud.points), config);
  ASSERT_TRUE(model.ok()) << model.status();
  const Box box = BoundingBox(cloud.points);
  EXPECT_TRUE(model->grid().origin.isApprox(0.5 * (box.min + box.max)));
  EXPECT_DOUBLE_EQ(model->grid().quantum, 1e-4 * box.diagonal());
}

TEST_F(SurfaceModelTest, ATargetThatIsOnePointIsRefused) {
  PointCloud cloud = SphereCloud(100, {0, 0, 0});
  cloud.points.setConstant(1);
  const auto model = SurfaceModel::Create(FrameCage(), BoundingBox(cloud.points), CageConfig());
  EXPECT_TRUE(absl::IsInvalidArgument(model.status())) << model.status();
}

TEST_F(SurfaceModelTest, ASurfaceOnItsTargetIsOk) {
  const Judgement judgement = JudgeMoved(0);
  EXPECT_EQ(judgement.verdict, Verdict::kOk);
  EXPECT_LT(judgement.rms_percent, 1e-4);
  EXPECT_EQ(judgement.distances.uncovered_share, 0);
  EXPECT_EQ(judgement.distances.samples, cloud_.size());
}

TEST_F(SurfaceModelTest, DistancesAreInTheUsersUnitsAndInPercent) {
  const Judgement judgement = JudgeMoved(0.005);
  EXPECT_GT(judgement.distances.max, 0.004 * diagonal_);
  EXPECT_LT(judgement.distances.max, 0.005 * diagonal_ * 1.001);
  EXPECT_DOUBLE_EQ(judgement.rms_percent, 100 * judgement.distances.rms / diagonal_);
}

TEST_F(SurfaceModelTest, ASurfaceBesideItsTargetIsSuspectAndFarFromItLost) {
  // h covers the points, so that distance alone decides.
  EXPECT_EQ(JudgeMoved(0.04, 0, 0.1 * diagonal_).verdict, Verdict::kSuspect);
  EXPECT_EQ(JudgeMoved(0.3, 0, diagonal_).verdict, Verdict::kLost);
}

TEST_F(SurfaceModelTest, MuchWorseThanTheMedianIsSuspect) {
  EXPECT_EQ(JudgeMoved(0.005).verdict, Verdict::kOk);
  EXPECT_EQ(JudgeMoved(0.005, 1e-4 * diagonal_).verdict, Verdict::kSuspect);
}

TEST_F(SurfaceModelTest, UncoveredPointsAreLost) {
  const Judgement judgement = JudgeMoved(0.04, 0, 0);
  EXPECT_GT(judgement.distances.uncovered_share, 0.25);
  EXPECT_EQ(judgement.verdict, Verdict::kLost);
}

TEST_F(SurfaceModelTest, AFoldedSurfaceIsNotOk) {
  Points3d vertices = cage_.vertices();
  for (Eigen::Index j = 0; j < vertices.cols(); j += 3) vertices.col(j) *= 0.2;
  EXPECT_NE(model_.Judge(cloud_, vertices, VerdictInput(), diagonal_).verdict, Verdict::kOk);
}

}  // namespace
}  // namespace cagefit::server
