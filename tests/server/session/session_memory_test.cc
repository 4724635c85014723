#include "server/session/session_memory.h"

#include <gtest/gtest.h>
#include <malloc.h>

#include <memory>

#include "tests/server/session/session_fixture.h"
#include "tests/support/sanitizer.h"

namespace cagefit::server {
namespace {

using cagefit::testing::FrameBytes;
using cagefit::testing::FrameCage;
using cagefit::testing::kIsSanitized;
using cagefit::testing::MovingCloud;
using testing::DecodedFrame;
using testing::OpenSession;

int64_t HeapBytes() {
  const struct mallinfo2 info = mallinfo2();
  return static_cast<int64_t>(info.uordblks + info.hblkhd);
}

SessionConfig ConfigOf(int levels) {
  SessionConfig config;
  config.control_mesh = FrameCage(levels);
  return config;
}

std::string MovingBytes(int frame, int64_t points) {
  return FrameBytes(MovingCloud(frame, points));
}

// By how much the heap grows with a session that fits two frames.
int64_t MeasuredBytes(const SessionConfig& config, int64_t points) {
  const std::string first = MovingBytes(0, points), second = MovingBytes(1, points);
  OpenSession session(config);
  const int64_t before = HeapBytes();
  EXPECT_TRUE(session.Answer(DecodedFrame(0, first)).ok());
  EXPECT_TRUE(session.Answer(DecodedFrame(1, second)).ok());
  return HeapBytes() - before;
}

class ModelBytesTest : public ::testing::Test {
 protected:
  void SetUp() override {
    if (kIsSanitized) GTEST_SKIP() << "the heap is not that of the C library";
    MeasuredBytes(ConfigOf(1), 500);  // what is allocated once for all
  }
  static void ExpectBetweenOnceAndThrice(const SessionConfig& config, int64_t points) {
    const int64_t measured = MeasuredBytes(config, points);
    const int64_t formula = ModelBytes(config, config.control_mesh->vertex_count(), points);
    EXPECT_GE(formula, measured) << config.control_mesh->vertex_count() << " " << points;
    EXPECT_LE(formula, 3 * measured) << config.control_mesh->vertex_count() << " " << points;
  }
};

TEST_F(ModelBytesTest, FollowsVerticesAndPoints) {
  for (const int levels : {2, 3, 4}) {
    for (const int64_t points : {2'000, 20'000, 100'000}) {
      ExpectBetweenOnceAndThrice(ConfigOf(levels), points);
    }
  }
}

TEST_F(ModelBytesTest, FollowsImages) {
  SessionConfig config = ConfigOf(3);
  config.fit.image.views = Views::kSphere;
  ExpectBetweenOnceAndThrice(config, 10'000);
  config.fit.image.view_count = 20;
  ExpectBetweenOnceAndThrice(config, 10'000);
}

TEST(IdleSessionBytesTest, AreWhatASessionKeepsWithoutItsModel) {
  if (kIsSanitized) GTEST_SKIP() << "the heap is not that of the C library";
  const std::string bytes = MovingBytes(0, 10'000);
  MeasuredBytes(ConfigOf(1), 500);
  const int64_t before = HeapBytes();
  const SessionConfig config = ConfigOf(4);
  OpenSession session(config);
  ASSERT_TRUE(session.Answer(DecodedFrame(0, bytes)).ok());
  session.session.DropModel();
  const int64_t measured = HeapBytes() - before;
  const int64_t formula = IdleSessionBytes(config, config.control_mesh->vertex_count());
  EXPECT_GE(formula, measured);
  EXPECT_LE(formula, 4 * measured);
}

TEST(HeldBytesTest, CountsCloudAndBytes) {
  const std::string bytes = MovingBytes(0, 1000);
  const Frame frame = DecodedFrame(0, bytes);
  EXPECT_EQ(HeldBytes(frame), static_cast<int64_t>(bytes.size()) + 1000 * 6 * 4);
}

TEST(MostFirstVerticesTest, AreThoseOfTheTemplateOrOfWhatToleranceModeMayMakeOfIt) {
  SessionConfig config = ConfigOf(1);
  SessionLimits limits;
  EXPECT_EQ(MostFirstVertices(config, limits, 1000), 42);
  config.tolerance = ToleranceOptions{1e-3, 0};
  EXPECT_EQ(MostFirstVertices(config, limits, 1000), MostToleranceVertices(1000));
  config.tolerance->max_vertices = 77;
  EXPECT_EQ(MostFirstVertices(config, limits, 1000), 77);
  limits.max_control_vertices = 50;
  EXPECT_EQ(MostFirstVertices(config, limits, 1000), 50);
}

}  // namespace
}  // namespace cagefit::server
