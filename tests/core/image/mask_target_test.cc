#include "core/image/mask_target.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "core/image/marching_squares.h"

namespace cagefit {
namespace {

Camera Raw(int width, int height) {
  Camera camera;
  camera.name = "left";
  camera.width = width;
  camera.height = height;
  camera.fx = camera.fy = 0.9 * width;
  camera.cx = 0.5 * (width - 1) + 3.25;
  camera.cy = 0.5 * (height - 1) - 1.75;
  return camera;
}

Distortion StrongDistortion() {
  Distortion d;
  d.k1 = -0.32;
  d.k2 = 0.12;
  d.p1 = 0.004;
  d.p2 = -0.003;
  return d;
}

// Share of each pixel's area whose undistorted position on the plane z = 1 is inside. Pixels with
// all corners on one side count as whole.
Image MaskOf(const Camera& camera, int samples,
             const std::function<bool(const Eigen::Vector2d&)>& inside) {
  const auto inside_at = [&](double u, double v) {
    const Eigen::Vector2d distorted((u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy);
    return inside(Undistort(camera.distortion, distorted)) ? 1 : 0;
  };
  Image mask(camera.width, camera.height);
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      const int corners = inside_at(x - 0.5, y - 0.5) + inside_at(x + 0.5, y - 0.5) +
                          inside_at(x - 0.5, y + 0.5) + inside_at(x + 0.5, y + 0.5);
      if (samples > 1 && corners % 4 == 0) {
        *mask.at(x, y) = corners == 4 ? 1.0f : 0.0f;
        continue;
      }
      int count = 0;
      for (int k = 0; k < samples * samples; ++k) {
        count += inside_at(x - 0.5 + (k % samples + 0.5) / samples,
                           y - 0.5 + (k / samples + 0.5) / samples);
      }
      *mask.at(x, y) = static_cast<float>(count) / static_cast<float>(samples * samples);
    }
  }
  return mask;
}

struct Disk {
  Eigen::Vector2d center;  // on the plane z = 1
  double radius;
  bool operator()(const Eigen::Vector2d& x) const { return (x - center).norm() < radius; }
};

// Root mean square and largest difference, over the observed pixels within 4 of the true circle,
// to the image of the exact signed distance.
struct Difference {
  double rms = 0, largest = 0;
};
Difference FromExact(const ImageTarget& target, const Disk& disk) {
  const Camera& camera = target.camera;
  const Eigen::Vector2d center(camera.fx * disk.center[0] + camera.cx,
                               camera.fy * disk.center[1] + camera.cy);
  Difference difference;
  int count = 0;
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      const double d = camera.fx * disk.radius - (Eigen::Vector2d(x, y) - center).norm();
      if (std::abs(d) > 4 || *target.observed.at(x, y) == 0) continue;
      const double s = d / camera.half_side();
      const double expected = 1 / (1 + std::exp(-s * std::abs(s) / kSilhouetteSigma));
      const double error = *target.silhouette.at(x, y) - expected;
      difference.rms += error * error;
      difference.largest = std::max(difference.largest, std::abs(error));
      ++count;
    }
  }
  difference.rms = std::sqrt(difference.rms / count);
  return difference;
}

TEST(MaskTargetTest, OfAHardEdgedDiskIsCloseToTheExactSilhouette) {
  const Camera camera = Raw(512, 512);
  const Disk disk{{0.013, -0.021}, 0.31};
  const Image mask = MaskOf(camera, 1, disk);

  Outline outline;
  ExtractOutline(mask, 0.5f, &outline);
  const Eigen::Vector2d center = camera.fx * disk.center + Eigen::Vector2d(camera.cx, camera.cy);
  double moment = 0, length = 0;
  for (int s = 0; s < outline.segments.cols(); ++s) {
    const Eigen::Vector2d a = outline.points.col(outline.segments(0, s));
    const Eigen::Vector2d b = outline.points.col(outline.segments(1, s));
    moment += (b - a).norm() * (0.5 * (a + b) - center).norm();
    length += (b - a).norm();
  }
  EXPECT_NEAR(moment / length, camera.fx * disk.radius, 0.02);

  const auto target = MaskTarget(mask, camera, 256);
  ASSERT_TRUE(target.ok());
  EXPECT_EQ(target->camera.width, 256);
  const Difference difference = FromExact(*target, disk);
  EXPECT_LT(difference.rms, 0.02);
  EXPECT_LT(difference.largest, 0.08);
}

TEST(MaskTargetTest, OfASmoothEdgeIsCloser) {
  const Camera camera = Raw(512, 512);
  const Disk disk{{0.013, -0.021}, 0.31};
  const auto target = MaskTarget(MaskOf(camera, 8, disk), camera, 256);
  ASSERT_TRUE(target.ok());
  const Difference difference = FromExact(*target, disk);
  EXPECT_LT(difference.rms, 0.005);
  EXPECT_LT(difference.largest, 0.025);
}

TEST(MaskTargetTest, UndistortsTheOutline) {
  // A silhouette value gives its distance back: |s| = sqrt(sigma |logit A|).
  Camera camera = Raw(640, 480);
  camera.distortion = StrongDistortion();
  const Disk disk{{0.05, -0.03}, 0.34};
  const auto target = MaskTarget(MaskOf(camera, 8, disk), camera, 320);
  ASSERT_TRUE(target.ok());
  const Camera& pinhole = target->camera;
  EXPECT_TRUE(pinhole.distortion.is_zero());
  EXPECT_EQ(pinhole.height, 240);
  const Eigen::Vector2d center(pinhole.fx * disk.center[0] + pinhole.cx,
                               pinhole.fy * disk.center[1] + pinhole.cy);
  double sum = 0, squares = 0;
  int count = 0;
  for (int y = 0; y < pinhole.height; ++y) {
    for (int x = 0; x < pinhole.width; ++x) {
      const double A = *target->silhouette.at(x, y);
      if (A < 1e-3 || A > 1 - 1e-3 || *target->observed.at(x, y) == 0) continue;
      const double logit = std::log(A / (1 - A));
      const double s = std::copysign(std::sqrt(kSilhouetteSigma * std::abs(logit)), logit);
      const double d = (Eigen::Vector2d(x, y) - center).norm();
      const double error = s * pinhole.half_side() - (pinhole.fx * disk.radius - d);
      ASSERT_NEAR(error, 0, 0.1) << x << " " << y;
      sum += error;
      squares += error * error;
      ++count;
    }
  }
  ASSERT_GT(count, 2000);
  EXPECT_NEAR(sum / count, 0, 0.01);
  EXPECT_LT(std::sqrt(squares / count), 0.05);
}

TEST(MaskTargetTest, ClaimsNothingOutsideTheRawMask) {
  // Pincushion: corners of the pinhole image lie outside the raw one. Without distortion none do.
  Camera camera = Raw(160, 120);
  const Image mask(160, 120, 1, 1.0f);
  auto target = MaskTarget(mask, camera, 80);
  ASSERT_TRUE(target.ok());
  for (const float observed : target->observed.values) ASSERT_EQ(observed, 1.0f);
  for (const float A : target->silhouette.values) ASSERT_EQ(A, 1.0f);

  camera.distortion.k1 = 0.3;
  target = MaskTarget(mask, camera, 80);
  ASSERT_TRUE(target.ok());
  EXPECT_EQ(*target->observed.at(0, 0), 0.0f);
  EXPECT_EQ(*target->observed.at(40, 30), 1.0f);
  for (int y = 0; y < 60; ++y) {
    for (int x = 0; x < 80; ++x) {
      const Eigen::Vector2d ray((x - target->camera.cx) / target->camera.fx,
                                (y - target->camera.cy) / target->camera.fy);
      const Eigen::Vector2d d = Distort(camera.distortion, ray);
      const double u = camera.fx * d[0] + camera.cx, v = camera.fy * d[1] + camera.cy;
      const bool within = u >= -0.5 && v >= -0.5 && u <= 159.5 && v <= 119.5;
      ASSERT_EQ(*target->observed.at(x, y), within ? 1.0f : 0.0f) << x << " " << y;
    }
  }
}

TEST(MaskTargetTest, ClaimsNothingWhereTheDistortionFoldsBack) {
  // Barrel distortion of a wide lens: beyond r = 1 / sqrt(3 * 0.45) = 0.86 its polynomial turns
  // round, and the corners of the pinhole image would look into the raw mask once more.
  Camera camera = Raw(200, 200);
  camera.fx = camera.fy = 90;
  camera.distortion.k1 = -0.45;
  const auto target = MaskTarget(Image(200, 200, 1, 1.0f), camera, 200);
  ASSERT_TRUE(target.ok());
  EXPECT_EQ(*target->observed.at(100, 100), 1.0f);
  EXPECT_EQ(*target->observed.at(1, 1), 0.0f);
}

TEST(MaskTargetTest, AMaskOfAnotherSizeIsAnError) {
  const auto target = MaskTarget(Image(64, 48), Raw(640, 480), 256);
  ASSERT_EQ(target.status().code(), absl::StatusCode::kInvalidArgument);
  const std::string message(target.status().message());
  for (const char* part : {"left", "64 x 48", "640 x 480"}) {
    EXPECT_NE(message.find(part), std::string::npos) << message;
  }
  EXPECT_EQ(MaskTarget(Image(64, 48, 3), Raw(64, 48), 32).status().code(),
            absl::StatusCode::kInvalidArgument);
}

}  // namespace
}  // namespace cagefit
