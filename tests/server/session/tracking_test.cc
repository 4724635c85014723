// Sessions that follow a body through jumps and bad frames; its true motion is known.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "core/base/random.h"
#include "core/cloud/surface_cloud.h"
#include "core/metrics/drift.h"
#include "core/subdiv/limit.h"
#include "tests/server/session/session_fixture.h"

namespace cagefit::server {
namespace {

using testing::DecodedFrame;
using testing::OpenSession;

// How far the body goes in one frame.
struct Speed {
  double shift = 0;  // along (1, 2, 2) / 3
  double turn = 0;   // about (1, 1, 0), radians
};

// A body without symmetry that bends to and fro, as a map of the unit sphere.
class Body {
 public:
  explicit Body(const Speed& speed) : speed_(speed) {}

  Points3d Place(const Points3d& sphere, int frame) const {
    Points3d X(3, sphere.cols());
    const double bend = 0.15 * std::sin(0.6 * frame);
    for (int64_t i = 0; i < X.cols(); ++i) {
      const Eigen::Vector3d s = sphere.col(i);
      const double z = 0.9 * s.z() + 0.2 * s.x() * s.x();
      X.col(i) << 0.6 * s.x() * (1 + 0.4 * s.z()), 0.35 * s.y() + 0.15 * s.x() + bend * z * z, z;
    }
    const Eigen::AngleAxisd turn(speed_.turn * frame, Eigen::Vector3d(1, 1, 0).normalized());
    const Eigen::Vector3d shift = speed_.shift * frame * Eigen::Vector3d(1, 2, 2) / 3;
    return (turn.toRotationMatrix() * X).colwise() + shift;
  }

  // 10,242 points, others in every frame.
  PointCloud Cloud(int frame) const {
    Random random(100 + frame);
    TriangleMesh mesh = cagefit::testing::Icosphere(5);
    const double angle = 3 * random.Uniform();
    const Eigen::AngleAxisd any(angle, random.NormalVector().normalized());
    mesh.vertices = Place(any.toRotationMatrix() * mesh.vertices, frame);
    return CloudFromMesh(mesh);
  }

  double Diagonal() const { return BoundingBox(Cloud(0).points).diagonal(); }

 private:
  Speed speed_;
};

PointCloud Noise(const PointCloud& like) {
  PointCloud cloud = like;
  Random random(7);
  const Box box = BoundingBox(like.points);
  for (int64_t i = 0; i < cloud.size(); ++i) {
    for (int axis = 0; axis < 3; ++axis) {
      cloud.points(axis, i) = static_cast<float>(random.Uniform(box.min[axis], box.max[axis]));
    }
    cloud.normals.col(i) = random.NormalVector().normalized().cast<float>();
  }
  return cloud;
}

// The points whose normals face +y: one camera's view.
PointCloud HalfOf(const PointCloud& cloud) {
  PointCloud half = cloud;
  int64_t kept = 0;
  for (int64_t i = 0; i < cloud.size(); ++i) {
    if (cloud.normals(1, i) < 0) continue;
    half.points.col(kept) = cloud.points.col(i);
    half.normals.col(kept++) = cloud.normals.col(i);
  }
  half.points.conservativeResize(3, kept);
  half.normals.conservativeResize(3, kept);
  return half;
}

class Tracker {
 public:
  explicit Tracker(const Speed& speed) : body_(speed), open_(Config(body_)) {
    limit_ = BuildLimitMesh(cage().topology(), cage().tags(), kMetricLevels);
    material_ = cagefit::testing::Icosphere(3).vertices;
  }

  Verdict Fit(const PointCloud& cloud) {
    const auto answer = open_.Answer(DecodedFrame(next_++, cagefit::testing::FrameBytes(cloud)));
    EXPECT_TRUE(answer.ok()) << answer.status();
    return answer->frame->verdict;
  }
  Verdict FitGood(int frame) { return Fit(body_.Cloud(frame)); }

  // Mean drift of the last fit, which is of `frame`, since the first; share of the diagonal.
  double Drift(int frame) const {
    TriangleMesh first;
    first.triangles = limit_.triangles;
    ApplyStencils(limit_.position, open_.Vertices(0), &first.vertices);
    Points3d now;
    ApplyStencils(limit_.position, open_.Vertices(next_ - 1), &now);
    const DriftMeter meter(first, body_.Place(material_, 0));
    return meter.Measure(now, body_.Place(material_, frame)).mean / body_.Diagonal();
  }

  const Body& body() const { return body_; }

 private:
  const ControlMesh& cage() const { return *open_.ledger->config().control_mesh; }
  static SessionConfig Config(const Body& body) {
    TriangleMesh mesh = cagefit::testing::Icosphere(3);
    SessionConfig config;
    config.control_mesh =
        ControlMesh::Create(body.Place(mesh.vertices, 0), std::move(mesh.triangles)).value();
    return config;
  }

  Body body_;
  OpenSession open_;
  LimitMesh limit_;
  Points3d material_;
  uint64_t next_ = 0;
};

// A tenth of the diagonal a frame.
Speed Jumping(double shift_share, double turn) { return {shift_share * Body({}).Diagonal(), turn}; }

TEST(TrackingTest, ABodyThatJumpsByATenthOfItsDiagonalKeepsItsMaterialPoints) {
  for (const Speed& speed : {Jumping(0, 0), Jumping(0.1, 0), Jumping(0, 0.4), Jumping(0.1, 0.4)}) {
    Tracker tracker(speed);
    double worst = 0;
    for (int frame = 0; frame < 8; ++frame) {
      EXPECT_EQ(tracker.FitGood(frame), Verdict::kOk) << frame;
      worst = std::max(worst, tracker.Drift(frame));
    }
    EXPECT_LT(worst, 0.01) << speed.shift << " " << speed.turn;
  }
}

TEST(TrackingTest, AJumpOutOfRestIsFollowedWithoutAVelocity) {
  Tracker tracker(Jumping(0.1, 0.4));
  EXPECT_EQ(tracker.FitGood(0), Verdict::kOk);
  EXPECT_EQ(tracker.FitGood(0), Verdict::kOk);
  EXPECT_EQ(tracker.FitGood(1), Verdict::kOk);
  EXPECT_LT(tracker.Drift(1), 0.01);
}

TEST(TrackingTest, GarbageIsNotOkAHalfIsFollowedAndGoodFramesRecover) {
  Tracker tracker(Jumping(0.02, 0.05));
  for (int frame = 0; frame < 4; ++frame) EXPECT_EQ(tracker.FitGood(frame), Verdict::kOk);
  // LOST where the surface folds over in it, else SUSPECT.
  EXPECT_NE(tracker.Fit(Noise(tracker.body().Cloud(4))), Verdict::kOk);
  EXPECT_EQ(tracker.FitGood(5), Verdict::kOk) << "from the surface of frame 3";
  EXPECT_LT(tracker.Drift(5), 0.01);
  EXPECT_EQ(tracker.Fit(HalfOf(tracker.body().Cloud(6))), Verdict::kSuspect)
      << "though the surface lies on all points that there are";
  for (int frame = 7; frame < 10; ++frame) EXPECT_EQ(tracker.FitGood(frame), Verdict::kOk);
  EXPECT_LT(tracker.Drift(9), 0.01);
}

}  // namespace
}  // namespace cagefit::server
