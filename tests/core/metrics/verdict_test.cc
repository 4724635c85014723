#include "core/metrics/verdict.h"

#include <gtest/gtest.h>

#include "tests/support/shapes.h"

namespace cagefit {
namespace {

VerdictInput Good() {
  VerdictInput input;
  input.distances.rms = 0.001;
  input.distances.samples = 4000;
  input.median_rms = 0.001;
  input.diagonal = 1;
  return input;
}

TEST(VerdictTest, SamplesAreSpreadOverTheCloud) {
  const TriangleMesh plane = testing::OpenGrid(1);
  const TriangleBvh surface(plane.vertices, plane.triangles);
  PointCloud cloud;
  cloud.points = Points3f::Constant(3, 1000, 0.5f);
  cloud.points.row(2).setZero();
  cloud.points.row(2).tail(250).setConstant(0.2f);
  const SampledDistances sampled = SampleDistances(cloud, surface, 100, 0.1);
  EXPECT_EQ(sampled.samples, 100);
  EXPECT_NEAR(sampled.uncovered_share, 0.25, 0.011);
  EXPECT_NEAR(sampled.max, 0.2, 1e-6);
  EXPECT_NEAR(sampled.mean, 0.05, 3e-3);
  EXPECT_EQ(SampleDistances(cloud, surface, 5000, 0.1).samples, 1000);
}

TEST(VerdictTest, AGoodFitIsOk) { EXPECT_EQ(Judge(Good()), Verdict::kOk); }

TEST(VerdictTest, AFirstFrameHasNoMedian) {
  VerdictInput input = Good();
  input.median_rms = 0;
  EXPECT_EQ(Judge(input), Verdict::kOk);
}

TEST(VerdictTest, WhatAPersonWouldLookAtIsSuspect) {
  VerdictInput uncovered = Good(), worse = Good(), far = Good(), flipped = Good();
  uncovered.distances.uncovered_share = 0.05;
  worse.distances.rms = 0.004;
  far.distances.rms = far.median_rms = 0.02;
  flipped.flipped_share = 0.03;
  for (const VerdictInput& input : {uncovered, worse, far, flipped}) {
    EXPECT_EQ(Judge(input), Verdict::kSuspect);
  }
  VerdictInput tiny = Good();  // four times a median that is next to nothing
  tiny.median_rms = 1e-5;
  tiny.distances.rms = 4e-5;
  EXPECT_EQ(Judge(tiny), Verdict::kOk);
}

TEST(VerdictTest, WhatNoFrameShouldStartFromIsLost) {
  VerdictInput uncovered = Good(), far = Good(), flipped = Good();
  uncovered.distances.uncovered_share = 0.5;
  far.distances.rms = far.median_rms = 0.1;
  flipped.flipped_share = 0.2;
  for (const VerdictInput& input : {uncovered, far, flipped}) {
    EXPECT_EQ(Judge(input), Verdict::kLost);
  }
}

TEST(VerdictTest, ASurfaceThatIsSuddenlyBareIsSuspect) {
  VerdictInput input;
  input.diagonal = 1;
  input.bare_share = 0.4;
  EXPECT_EQ(Judge(input), Verdict::kOk) << "a first frame may show a part only";
  input.median_bare_share = 0.38;
  EXPECT_EQ(Judge(input), Verdict::kOk) << "as usual";
  input.median_bare_share = 0.1;
  EXPECT_EQ(Judge(input), Verdict::kSuspect);
}

}  // namespace
}  // namespace cagefit
