#include "server/session/frame.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>
#include <utility>

#include "server/session/error_detail.h"
#include "tests/server/session/session_fixture.h"
#include "tests/support/masks.h"

namespace cagefit::server {
namespace {

using cagefit::testing::FrameBytes;
using cagefit::testing::FrameCage;
using cagefit::testing::MaskPng;
using cagefit::testing::SmallCamera;
using cagefit::testing::SphereCloud;
using testing::DecodedFrame;
using testing::ReasonOf;

Frame StatedFrame(uint64_t point_count, const std::string& bytes,
                  const DecodeLimits& limits = DecodeLimits()) {
  Frame frame;
  frame.point_count = point_count;
  frame.bytes = bytes;
  DecodeFrame(limits, {}, testing::NoTime, &frame);
  return frame;
}

TEST(FrameTest, DecodesAndHashesTheBytes) {
  const std::string bytes = FrameBytes(SphereCloud(100, {0, 0, 0}));
  const Frame frame = DecodedFrame(0, bytes);
  ASSERT_TRUE(frame.cloud.ok()) << frame.cloud.status();
  EXPECT_EQ(frame.cloud->size(), 100);
  EXPECT_EQ(frame.digest, Sha256(bytes));
}

TEST(FrameTest, MeasuresByTheCallersClock) {
  Frame frame;
  frame.bytes = FrameBytes(SphereCloud(100, {0, 0, 0}));
  double now = 10;
  DecodeFrame(
      DecodeLimits(), {}, [&now] { return now += 5; }, &frame);
  EXPECT_EQ(frame.decode_ms, 5);
}

TEST(FrameTest, EstimatesNormalsWhereThereAreNone) {
  PointCloud cloud = SphereCloud(2000, {0, 0, 0});
  cloud.normals.resize(3, 0);
  const Frame frame = DecodedFrame(0, FrameBytes(cloud));
  ASSERT_TRUE(frame.cloud.ok()) << frame.cloud.status();
  ASSERT_EQ(frame.cloud->normals.cols(), frame.cloud->size());
  for (Eigen::Index i = 0; i < frame.cloud->size(); ++i) {
    EXPECT_GT(std::abs(frame.cloud->normals.col(i).dot(frame.cloud->points.col(i))), 0.95f);
  }
}

TEST(FrameTest, BytesThatAreNotDracoAreABadFrame) {
  for (const std::string& bytes : {std::string(), std::string("\x89PNG\r\n\x1a\n", 8)}) {
    const Frame frame = DecodedFrame(0, bytes);
    EXPECT_TRUE(absl::IsInvalidArgument(frame.cloud.status())) << frame.cloud.status();
    EXPECT_EQ(ReasonOf(frame.cloud.status()), "BAD_FRAME");
  }
}

TEST(FrameTest, FewerThan16PointsAreABadFrame) {
  const Frame frame = DecodedFrame(0, FrameBytes(SphereCloud(15, {0, 0, 0})));
  EXPECT_TRUE(absl::IsInvalidArgument(frame.cloud.status())) << frame.cloud.status();
  EXPECT_EQ(ReasonOf(frame.cloud.status()), "BAD_FRAME");
}

TEST(FrameTest, TheStatedNumberOfPointsMustBeTrue) {
  const std::string bytes = FrameBytes(SphereCloud(100, {0, 0, 0}));
  EXPECT_TRUE(StatedFrame(0, bytes).cloud.ok());
  EXPECT_TRUE(StatedFrame(100, bytes).cloud.ok());
  for (const uint64_t wrong : {99u, 101u}) {
    const Frame frame = StatedFrame(wrong, bytes);
    EXPECT_TRUE(absl::IsInvalidArgument(frame.cloud.status())) << frame.cloud.status();
    EXPECT_EQ(DetailOf(frame.cloud.status())->field, "header.point_count");
  }
}

TEST(FrameTest, AMeshGivesItsSurfaceAndIsStatedByItsVertices) {
  const ControlMesh cage = FrameCage();
  const auto bytes = EncodeDracoMesh({cage.vertices(), cage.triangles()}, DracoMeshOptions());
  ASSERT_TRUE(bytes.ok()) << bytes.status();
  const Frame frame = StatedFrame(42, *bytes);
  ASSERT_TRUE(frame.cloud.ok()) << frame.cloud.status();
  EXPECT_GT(frame.cloud->size(), 10 * 42);
  EXPECT_TRUE(frame.cloud->has_normals());
  // Between the cage's vertices, which are 1.1 from its centre, and the middles of its triangles.
  const Eigen::RowVectorXf distances = frame.cloud->points.colwise().norm();
  EXPECT_LT(distances.maxCoeff(), 1.1f + 1e-5f);
  EXPECT_GT(distances.minCoeff(), 0.95f);

  ASSERT_TRUE(frame.mesh.has_value());
  EXPECT_TRUE(frame.mesh->triangles == cage.triangles());
  EXPECT_FALSE(DecodedFrame(0, FrameBytes(SphereCloud(100, {0, 0, 0}))).mesh.has_value());

  const Frame wrong = StatedFrame(43, *bytes);
  EXPECT_TRUE(absl::IsInvalidArgument(wrong.cloud.status())) << wrong.cloud.status();
}

// A frame with a mask of `left`, which is white, and one of `right`, half white.
Frame FrameWithMasks() {
  const std::string white = MaskPng(4, 3), half = MaskPng(4, 3, 0.5f);
  Frame frame;
  frame.bytes = FrameBytes(SphereCloud(100, {0, 0, 0})) + half + white;
  frame.stated_masks = {{"right", half.size()}, {"left", white.size()}};
  return frame;
}

const std::vector<Camera>& LeftMiddleRight() {
  static const auto* const cameras =
      new std::vector<Camera>{SmallCamera("left"), SmallCamera("middle"), SmallCamera("right")};
  return *cameras;
}

TEST(FrameTest, MasksFollowTheGeometryAndAreSortedByCamera) {
  Frame frame = FrameWithMasks();
  DecodeFrame(DecodeLimits(), LeftMiddleRight(), testing::NoTime, &frame);
  ASSERT_TRUE(frame.cloud.ok()) << frame.cloud.status();
  EXPECT_EQ(frame.cloud->size(), 100);
  EXPECT_EQ(frame.geometry(), FrameBytes(SphereCloud(100, {0, 0, 0})));
  ASSERT_EQ(frame.masks.size(), 3u);
  EXPECT_EQ(*frame.masks[0].at(3, 2), 1);
  EXPECT_TRUE(frame.masks[1].empty());
  EXPECT_NEAR(*frame.masks[2].at(0, 0), 0.5, 0.01);
}

TEST(FrameTest, ABadMaskIsABadFrame) {
  Frame frame = FrameWithMasks();
  frame.stated_masks[1].camera = "front";
  DecodeFrame(DecodeLimits(), LeftMiddleRight(), testing::NoTime, &frame);
  EXPECT_TRUE(absl::IsInvalidArgument(frame.cloud.status())) << frame.cloud.status();
  EXPECT_EQ(DetailOf(frame.cloud.status())->field, "header.masks[1].camera");

  frame = FrameWithMasks();
  frame.header_field = "frame";
  frame.stated_masks[0].png_bytes = 1 << 20;
  DecodeFrame(DecodeLimits(), LeftMiddleRight(), testing::NoTime, &frame);
  EXPECT_EQ(DetailOf(frame.cloud.status())->field, "frame.masks[0].png_bytes");
}

TEST(FrameTest, TheDigestTellsWhichCameraAMaskIsOf) {
  std::set<Digest> digests;
  for (int k = 0; k < 4; ++k) {
    Frame frame = FrameWithMasks();
    if (k == 1) std::swap(frame.stated_masks[0].camera, frame.stated_masks[1].camera);
    if (k == 2) frame.stated_masks.clear();
    if (k == 3) --frame.stated_masks[0].png_bytes;
    DecodeFrame(DecodeLimits(), LeftMiddleRight(), testing::NoTime, &frame);
    digests.insert(frame.digest);
  }
  EXPECT_EQ(digests.size(), 4u);
}

TEST(FrameTest, PointsAboveTheLimitAreExhaustion) {
  DecodeLimits limits;
  limits.max_points = 99;
  const std::string bytes = FrameBytes(SphereCloud(100, {0, 0, 0}));
  for (const uint64_t stated : {uint64_t{0}, uint64_t{100}, ~uint64_t{0}}) {
    const Frame frame = StatedFrame(stated, bytes, limits);
    EXPECT_TRUE(absl::IsResourceExhausted(frame.cloud.status())) << frame.cloud.status();
    EXPECT_EQ(ReasonOf(frame.cloud.status()), "LIMIT_EXCEEDED");
    EXPECT_THAT(std::string(frame.cloud.status().message()), ::testing::HasSubstr("99"));
    EXPECT_THAT(std::string(frame.cloud.status().message()),
                ::testing::Not(::testing::HasSubstr("-")));
  }
}

}  // namespace
}  // namespace cagefit::server
