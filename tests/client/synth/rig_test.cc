#include "client/synth/rig.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/image/mesh_renderer.h"

namespace cagefit::client {
namespace {

TEST(RigTest, EveryCameraSeesAllOfTheShapeAtAnyTime) {
  for (const std::string& name : ShapeNames()) {
    const auto shape = *MakeShape(name, 3);
    RigOptions options;
    options.cameras = 6;
    options.size = 64;
    const Rig rig(*shape, options, 1);
    ASSERT_EQ(rig.cameras().size(), 6u);
    for (const double time : {0.0, 0.3, 0.77}) {
      for (size_t k = 0; k < 6; ++k) {
        const Image mask = rig.Mask(*shape, time, k);
        int inside = 0;
        for (int y = 0; y < 64; ++y) {
          for (int x = 0; x < 64; ++x) {
            const float value = *mask.at(x, y);
            ASSERT_TRUE(value == 0 || value == 1);
            inside += value > 0;
            const bool at_border = std::min({x, y, 63 - x, 63 - y}) == 0;
            if (at_border) {
              EXPECT_EQ(value, 0) << name << " at " << time;
            }
          }
        }
        EXPECT_GT(inside, 100);
      }
    }
  }
}

TEST(RigTest, TheCalibrationIsOffByAsManyPixelsInDirectionsOfTheSeed) {
  const auto shape = *MakeShape("tube", 1);
  RigOptions options;
  options.cameras = 5;
  options.error = 2;
  const Rig rig(*shape, options, 1), again(*shape, options, 1), other(*shape, options, 2);
  for (size_t k = 0; k < 5; ++k) {
    const Camera &a = rig.cameras()[k], &b = rig.calibrated()[k];
    EXPECT_NEAR(std::hypot(b.cx - a.cx, b.cy - a.cy), 2, 1e-12);
    EXPECT_EQ(a.name, b.name);
    EXPECT_EQ(a.R, b.R);
    EXPECT_EQ(again.calibrated()[k].cx, b.cx);
    EXPECT_NE(other.calibrated()[k].cx, b.cx);
    if (k > 0) {
      EXPECT_NE(b.cx - a.cx, rig.calibrated()[0].cx - rig.cameras()[0].cx);
    }
  }
}

TEST(RigTest, TakesMasksOfEverySoManyFrames) {
  RigOptions options;
  options.cameras = 1;
  options.every = 3;
  const auto shape = *MakeShape("blob", 1);
  const Rig rig(*shape, options, 1);
  for (int frame = 0; frame < 9; ++frame) EXPECT_EQ(rig.TakesMasksOf(frame), frame % 3 == 0);
}

TEST(RigTest, OptionsOutOfRangeAreNamed) {
  const auto message_of = [](auto change) {
    RigOptions options;
    change(&options);
    return std::string(options.Validate().message());
  };
  EXPECT_EQ(message_of([](auto* o) { o->cameras = 65; }), "cameras is 65; it must be from 0 to 64");
  EXPECT_EQ(message_of([](auto* o) { o->size = 63; }),
            "mask_size is 63; it must be from 64 to 2048");
  EXPECT_EQ(message_of([](auto* o) { o->every = 0; }),
            "masks_every is 0; it must be from 1 to 100000");
  EXPECT_EQ(message_of([](auto* o) { o->error = -1; }),
            "camera_error is -1; it must be from 0 to 100");
  EXPECT_TRUE(RigOptions().Validate().ok());
}

}  // namespace
}  // namespace cagefit::client
