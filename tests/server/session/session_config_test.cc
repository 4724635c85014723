#include "server/session/session_config.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "server/session/error_detail.h"
#include "tests/server/session/session_fixture.h"
#include "tests/support/masks.h"

namespace cagefit::server {
namespace {

using cagefit::testing::SmallCamera;
using ::testing::AllOf;
using ::testing::HasSubstr;

void ExpectRefused(const SessionConfig& config, const std::string& field,
                   const std::string& value) {
  const absl::Status status = config.Validate();
  EXPECT_TRUE(absl::IsInvalidArgument(status)) << status;
  EXPECT_THAT(std::string(status.message()), AllOf(HasSubstr(field), HasSubstr(value)));
  const auto detail = DetailOf(status);
  ASSERT_TRUE(detail.has_value());
  EXPECT_EQ(detail->reason, "INVALID_FIELD");
}

TEST(SessionConfigTest, DefaultsAreValidWithAMeshOrAWishForOne) {
  EXPECT_EQ(testing::CageConfig().Validate(), absl::OkStatus());
  SessionConfig wish;
  wish.make_template.vertices = 4;
  EXPECT_EQ(wish.Validate(), absl::OkStatus());
}

TEST(SessionConfigTest, TakesTheEndsOfEveryRange) {
  SessionConfig config = testing::CageConfig();
  config.name.assign(200, 'x');
  for (const double quantum : {0.0, 1e-9, 1e-2}) {
    config.quantum = quantum;
    EXPECT_EQ(config.Validate(), absl::OkStatus()) << quantum;
  }
  for (const uint32_t interval : {1u, 100'000u}) {
    config.key_interval = interval;
    EXPECT_EQ(config.Validate(), absl::OkStatus()) << interval;
  }
}

TEST(SessionConfigTest, RefusesAQuantumOutOfRange) {
  SessionConfig config = testing::CageConfig();
  for (const double quantum : {-1e-5, 0.9e-9, 1.1e-2, std::nan(""), HUGE_VAL}) {
    config.quantum = quantum;
    ExpectRefused(config, "options.quantum", "1e-9 to 1e-2");
  }
}

TEST(SessionConfigTest, RefusesAKeyIntervalOutOfRange) {
  SessionConfig config = testing::CageConfig();
  config.key_interval = 0;
  ExpectRefused(config, "options.key_interval", "0");
  config.key_interval = 100'001;
  ExpectRefused(config, "options.key_interval", "100001");
}

TEST(SessionConfigTest, RefusesALongName) {
  SessionConfig config = testing::CageConfig();
  config.name.assign(201, 'x');
  ExpectRefused(config, "name", "201");
}

TEST(SessionConfigTest, RefusesTooFewVerticesOfATemplate) {
  SessionConfig config;
  for (const int32_t vertices : {-1, 0, 3}) {
    config.make_template.vertices = vertices;
    ExpectRefused(config, "make_template.vertices", std::to_string(vertices));
  }
}

TEST(SessionConfigTest, RefusesACreaseAngleOutOfRange) {
  SessionConfig config;
  config.make_template.vertices = 4;
  for (const double angle : {0.0, 180.0}) {
    config.make_template.crease_angle_degrees = angle;
    EXPECT_EQ(config.Validate(), absl::OkStatus()) << angle;
  }
  for (const double angle : {-1.0, 180.5, std::nan("")}) {
    config.make_template.crease_angle_degrees = angle;
    ExpectRefused(config, "make_template.crease_angle_degrees", std::to_string(angle).substr(0, 2));
  }
}

TEST(SessionConfigTest, RefusesAToleranceOutOfRange) {
  SessionConfig config = testing::CageConfig();
  for (const double tolerance : {1e-6, 0.1}) {
    config.tolerance = ToleranceOptions{tolerance, 0};
    EXPECT_EQ(config.Validate(), absl::OkStatus()) << tolerance;
  }
  config.tolerance = ToleranceOptions{0.25, 0};
  ExpectRefused(config, "options.tolerance", "0.25");
  config.tolerance = ToleranceOptions{-1, 0};
  ExpectRefused(config, "options.tolerance", "-1");
  config.tolerance = ToleranceOptions{1e-3, 3};
  ExpectRefused(config, "options.max_vertices", "3");
  config.tolerance = ToleranceOptions{1e-3, -7};
  ExpectRefused(config, "options.max_vertices", "-7");
}

TEST(SessionConfigTest, RefusesBadFitOptionsNamingThem) {
  SessionConfig config = testing::CageConfig();
  config.fit.solver.max_iterations = 100'001;
  ExpectRefused(config, "options.fit.max_iterations", "100001");
  EXPECT_EQ(DetailOf(config.Validate())->field, "options.fit.max_iterations");
  EXPECT_EQ(DetailOf(config.Validate())->value, "100001");
}

TEST(SessionConfigTest, ViewsOfCamerasNeedCameras) {
  SessionConfig config = testing::CageConfig();
  config.fit.image.views = Views::kCameras;
  ASSERT_TRUE(absl::IsInvalidArgument(config.Validate())) << config.Validate();
  EXPECT_EQ(DetailOf(config.Validate())->field, "options.fit.image.views");
  config.cameras = {SmallCamera("left")};
  EXPECT_EQ(config.Validate(), absl::OkStatus());
}

TEST(SessionConfigTest, CamerasAreNamedDifferentlyAndValid) {
  SessionConfig config = testing::CageConfig();
  config.cameras = {SmallCamera("left"), SmallCamera("right")};
  EXPECT_EQ(config.Validate(), absl::OkStatus());
  const auto field = [&config](int k, const Camera& camera) {
    config.cameras[k] = camera;
    const absl::Status status = config.Validate();
    EXPECT_TRUE(absl::IsInvalidArgument(status)) << status;
    return DetailOf(status)->field;
  };
  EXPECT_EQ(field(1, SmallCamera("left")), "options.cameras[1].name");
  EXPECT_EQ(field(1, SmallCamera("")), "options.cameras[1].name");
  EXPECT_EQ(field(1, SmallCamera(std::string(201, 'x'))), "options.cameras[1].name");
  Camera flat = SmallCamera("right");
  flat.height = 0;
  EXPECT_EQ(field(1, flat), "options.cameras[1].height");
  EXPECT_EQ(config.Validate().message(), "options.cameras[1].height is 0; expected 1 to 16384");
  Camera nowhere = SmallCamera("right");
  nowhere.t[1] = std::nan("");
  EXPECT_EQ(field(1, nowhere), "options.cameras[1].translation");
  config.cameras.assign(SessionConfig::kMaxCameras + 1, SmallCamera("left"));
  EXPECT_EQ(DetailOf(config.Validate())->field, "options.cameras");
}

}  // namespace
}  // namespace cagefit::server
