#include "core/image/camera.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <limits>

namespace cagefit {
namespace {

Camera Sample() {
  Camera camera;
  camera.name = "left";
  camera.width = 640;
  camera.height = 480;
  camera.fx = 500;
  camera.fy = 510;
  camera.cx = 320.5;
  camera.cy = 230.25;
  camera.R = Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, -1).normalized()).toRotationMatrix();
  camera.t = Eigen::Vector3d(0.1, -0.2, 3);
  return camera;
}

TEST(CameraTest, ProjectsAPointOnTheAxisToThePrincipalPoint) {
  const Camera camera = Sample();
  const Eigen::Vector3d X = camera.R.transpose() * (Eigen::Vector3d(0, 0, 5) - camera.t);

  EXPECT_TRUE(camera.Project(X).isApprox(Eigen::Vector3d(320.5, 230.25, 5), 1e-12));
}

TEST(CameraTest, LooksAtItsTargetWithUpUpwards) {
  const Eigen::Vector3d eye(2, 1, 3), target(0.5, 0, 0), up(0, 1, 0);
  const Camera camera = LookAt(eye, target, up, M_PI / 3, 256);

  ASSERT_TRUE(camera.Validate().ok());
  EXPECT_TRUE(camera.center().isApprox(eye, 1e-12));
  EXPECT_TRUE(
      camera.Project(target).isApprox(Eigen::Vector3d(127.5, 127.5, (eye - target).norm()), 1e-12));
  const Eigen::Vector3d above = camera.Project(target + 0.1 * up);
  EXPECT_NEAR(above[0], 127.5, 1e-9);
  EXPECT_LT(above[1], 127.5);
  // Half the field of view ends at the image's border, half a pixel outside the last centre.
  const double distance = (target - eye).norm();
  const Eigen::Vector3d right = camera.R.row(0).transpose();
  EXPECT_NEAR(camera.Project(target + distance * std::tan(M_PI / 6) * right)[0], 255.5, 1e-9);
}

TEST(CameraTest, ResizingKeepsPixelAreasInTheirPlace) {
  const Camera camera = Sample();
  const Camera half = Resized(camera, 320);
  EXPECT_EQ(half.width, 320);
  EXPECT_EQ(half.height, 240);
  const Eigen::Vector3d X(0.3, 0.2, -0.4);
  const Eigen::Vector3d p = camera.Project(X), q = half.Project(X);
  EXPECT_NEAR(0.5 * (p[0] + 0.5), q[0] + 0.5, 1e-9);
  EXPECT_NEAR(0.5 * (p[1] + 0.5), q[1] + 0.5, 1e-9);
}

TEST(CameraTest, SeesTheSameImageInOtherCoordinates) {
  const Camera camera = Sample();
  const Eigen::Vector3d center(1, -2, 0.5), X(0.3, 0.2, -0.4);
  const double scale = 0.25;
  const Camera other = InCoordinates(camera, center, scale);
  const Eigen::Vector3d p = camera.Project(X), q = other.Project(scale * (X - center));
  EXPECT_NEAR(p[0], q[0], 1e-9);
  EXPECT_NEAR(p[1], q[1], 1e-9);
  EXPECT_NEAR(scale * p[2], q[2], 1e-12);
}

TEST(CameraTest, UndistortsWhatItDistorts) {
  const Distortion lens{-0.28, 0.07, 2e-4, -5e-4, 0.01};
  for (double x = -0.6; x <= 0.6; x += 0.15) {
    for (double y = -0.4; y <= 0.4; y += 0.1) {
      const Eigen::Vector2d point(x, y);
      EXPECT_LT((Undistort(lens, Distort(lens, point)) - point).norm(), 1e-9);
    }
  }
}

// OpenCV's projectPoints by its published formula, term by term.
TEST(CameraTest, DistortsByTheFormulaOfItsTerms) {
  const Eigen::Vector2d x(0.3, -0.2);
  const double r2 = 0.13;
  EXPECT_TRUE(Distort({0.5, 0, 0, 0, 0}, x).isApprox(x * (1 + 0.5 * r2)));
  EXPECT_TRUE(Distort({0, 0.5, 0, 0, 0}, x).isApprox(x * (1 + 0.5 * r2 * r2)));
  EXPECT_TRUE(Distort({0, 0, 0, 0, 0.5}, x).isApprox(x * (1 + 0.5 * r2 * r2 * r2)));
  EXPECT_TRUE(Distort({0, 0, 0.5, 0, 0}, x)
                  .isApprox(x + 0.5 * Eigen::Vector2d(2 * 0.3 * -0.2, r2 + 2 * 0.04)));
  EXPECT_TRUE(Distort({0, 0, 0, 0.5, 0}, x)
                  .isApprox(x + 0.5 * Eigen::Vector2d(r2 + 2 * 0.09, 2 * 0.3 * -0.2)));
}

TEST(CameraTest, NamesTheFieldThatIsWrong) {
  const auto error = [](auto change) {
    Camera camera = Sample();
    change(&camera);
    return std::string(camera.Validate().message());
  };
  EXPECT_TRUE(Sample().Validate().ok());
  EXPECT_EQ(error([](Camera* c) { c->width = 0; }),
            "camera \"left\": width is 0; expected 1 to 16384");
  EXPECT_EQ(error([](Camera* c) { c->fy = -1; }), "camera \"left\": fy is -1; expected above 0");
  EXPECT_EQ(error([](Camera* c) { c->distortion.p1 = std::numeric_limits<double>::infinity(); }),
            "camera \"left\": p1 is inf; expected a finite number");
  EXPECT_NE(error([](Camera* c) { c->R.col(0) *= -1; }).find("R is no rotation"),
            std::string::npos);
  EXPECT_NE(error([](Camera* c) { c->t[1] = NAN; }).find("t is not finite"), std::string::npos);
}

}  // namespace
}  // namespace cagefit
