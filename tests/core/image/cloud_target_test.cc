#include "core/image/cloud_target.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/base/random.h"
#include "core/cloud/spacing.h"

namespace cagefit {
namespace {

constexpr int kSize = 256;
const Eigen::Vector3d kEye(1.4, 0.9, 2.6);

// The unit sphere is seen with a radius of some 80 pixels, off the axis.
Camera View() {
  Camera camera = LookAt(kEye, {0.12, -0.08, 0.05}, {0, 1, 0}, M_PI / 3, kSize);
  camera.fx = camera.fy = 80 * std::sqrt(kEye.squaredNorm() - 1);
  return camera;
}

// Points of the unit sphere, of those with x > 0 only the given share.
PointCloud Sphere(int count, double share = 1) {
  Random random(1);
  PointCloud cloud;
  cloud.points.resize(3, count);
  for (int i = 0; i < count;) {
    const Eigen::Vector3d p = random.NormalVector().normalized();
    if (p.x() > 0 && random.Uniform() >= share) continue;
    cloud.points.col(i++) = p.cast<float>();
  }
  cloud.normals = cloud.points;
  return cloud;
}

PointCloud Disk(int count) {
  Random random(1);
  PointCloud cloud;
  cloud.points.resize(3, count);
  for (int i = 0; i < count; ++i) {
    const double angle = random.Uniform(0, 2 * M_PI), r = std::sqrt(random.Uniform());
    cloud.points.col(i) =
        Eigen::Vector3d(r * std::cos(angle), r * std::sin(angle), 0).cast<float>();
  }
  return cloud;
}

PointCloud Torus(int count, double major_radius, double minor_radius) {
  Random random(1);
  PointCloud cloud;
  cloud.points.resize(3, count);
  for (int i = 0; i < count;) {
    const double a = random.Uniform(0, 2 * M_PI), b = random.Uniform(0, 2 * M_PI);
    const double from_axis = major_radius + minor_radius * std::cos(b);
    if (random.Uniform() * (major_radius + minor_radius) > from_axis) continue;
    cloud.points.col(i++) = Eigen::Vector3d(from_axis * std::cos(a), from_axis * std::sin(a),
                                            minor_radius * std::sin(b))
                                .cast<float>();
  }
  return cloud;
}

double Spacing(const PointCloud& cloud) {
  return MedianSpacing(cloud.points, KdTree(cloud.points));
}

Eigen::Vector3d RayOf(const Camera& camera, const Eigen::Vector2d& pixel) {
  return camera.R.transpose() *
         Eigen::Vector3d((pixel[0] - camera.cx) / camera.fx, (pixel[1] - camera.cy) / camera.fy, 1);
}

// The outline of the unit sphere: the cone of rays that touch it.
Outline SphereOutline(const Camera& camera) {
  constexpr int kCount = 4000;
  const Eigen::Vector3d eye = camera.center(), toward = -eye.normalized();
  const Eigen::Vector3d across = toward.unitOrthogonal(), other = toward.cross(across);
  const double slope = std::tan(std::asin(1 / eye.norm()));
  Outline outline;
  outline.points.resize(2, kCount);
  outline.segments.resize(2, kCount);
  for (int i = 0; i < kCount; ++i) {
    const double angle = 2 * M_PI * i / kCount;
    const Eigen::Vector3d ray =
        toward + slope * (std::cos(angle) * across + std::sin(angle) * other);
    outline.points.col(i) = camera.Project(eye + ray).head<2>();
    outline.segments.col(i) << i, (i + 1) % kCount;
  }
  return outline;
}

bool IsInsideSphere(const Camera& camera, const Eigen::Vector2d& pixel) {
  const Eigen::Vector3d ray = RayOf(camera, pixel).normalized(), eye = camera.center();
  return ray.cross(eye).norm() < 1;
}

// How far inside the sphere's outline a pixel lies, in pixels: from the line along the outline
// where that is nearest.
double InsideSphere(const Camera& camera, const Outline& exact, const Eigen::Vector2d& pixel) {
  Eigen::Index i;
  const double to_point = (exact.points.colwise() - pixel).colwise().squaredNorm().minCoeff(&i);
  const Eigen::Index count = exact.points.cols();
  const Eigen::Vector2d along =
      exact.points.col((i + 1) % count) - exact.points.col((i + count - 1) % count);
  const double offset = along.normalized().dot(pixel - exact.points.col(i));
  const double d = std::sqrt(std::max(0.0, to_point - offset * offset));
  return IsInsideSphere(camera, pixel) ? d : -d;
}

// Mean over the outline's length.
template <typename Function>
double MeanAlong(const Outline& outline, const Function& f) {
  double sum = 0, length = 0;
  for (int s = 0; s < outline.segments.cols(); ++s) {
    const Eigen::Vector2d a = outline.points.col(outline.segments(0, s));
    const Eigen::Vector2d b = outline.points.col(outline.segments(1, s));
    sum += (b - a).norm() * f(0.5 * (a + b));
    length += (b - a).norm();
  }
  return sum / length;
}

TEST(CloudTargetTest, TheOutlineOfASphereIsHardlyInside) {
  const Camera camera = View();
  const Outline exact = SphereOutline(camera);
  for (const auto& [count, most] : {std::pair(100'000, 0.03), std::pair(20'000, 0.07)}) {
    const PointCloud cloud = Sphere(count);
    CloudSplatter splatter;
    ImageTarget target;
    splatter.Splat(cloud, Spacing(cloud), camera, &target);
    const double inside = MeanAlong(splatter.outline(), [&](const Eigen::Vector2d& p) {
      return InsideSphere(camera, exact, p);
    });
    EXPECT_GE(inside, 0) << count;
    EXPECT_LT(inside, most) << count;
  }
}

TEST(CloudTargetTest, TheSilhouetteOfASphereIsThatOfItsExactOutline) {
  const Camera camera = View();
  const PointCloud cloud = Sphere(100'000);
  CloudSplatter splatter;
  ImageTarget target;
  splatter.Splat(cloud, Spacing(cloud), camera, &target);
  ASSERT_EQ(target.silhouette.pixel_count(), kSize * kSize);
  EXPECT_TRUE(target.observed.empty());
  const double reach = SilhouetteReach(kSilhouetteSigma, camera.half_side());
  OutlineDistance distance;
  MeasureOutline(SphereOutline(camera), kSize, kSize, reach, &distance);
  Image inside(kSize, kSize);
  for (int y = 0; y < kSize; ++y) {
    for (int x = 0; x < kSize; ++x) *inside.at(x, y) = IsInsideSphere(camera, {x, y}) ? 1.0f : 0.0f;
  }
  const Image exact = SilhouetteFromOutline(distance, inside, kSilhouetteSigma, camera.half_side());
  double squares = 0, largest = 0;
  int band = 0;
  for (int p = 0; p < kSize * kSize; ++p) {
    const double error = std::abs(target.silhouette.values[p] - exact.values[p]);
    largest = std::max(largest, error);
    if (distance.segment[p] < 0) continue;
    squares += error * error;
    ++band;
  }
  EXPECT_GT(band, 3000);
  EXPECT_LT(std::sqrt(squares / band), 0.003);
  EXPECT_LT(largest, 0.05);
}

TEST(CloudTargetTest, DensityMayVaryByAFactorOfFour) {
  const Camera camera = View();
  const Outline exact = SphereOutline(camera);
  const PointCloud cloud = Sphere(50'000, 0.25);
  CloudSplatter splatter;
  ImageTarget target;
  splatter.Splat(cloud, Spacing(cloud), camera, &target);
  for (int y = 0; y < kSize; ++y) {
    for (int x = 0; x < kSize; ++x) {
      const double d = InsideSphere(camera, exact, {x, y});
      if (std::abs(d) < 5) continue;
      ASSERT_EQ(*target.silhouette.at(x, y), d > 0 ? 1.0f : 0.0f) << x << " " << y;
    }
  }
}

TEST(CloudTargetTest, AnOpenSheetEndsHalfASpacingInsideItsEdge) {
  Camera camera = View();
  const PointCloud cloud = Disk(50'000);
  const double spacing = Spacing(cloud);
  CloudSplatter splatter;
  ImageTarget target;
  splatter.Splat(cloud, spacing, camera, &target);
  // Where the outline's rays meet the sheet's plane, the radius is short of 1.
  const double missing = MeanAlong(splatter.outline(), [&](const Eigen::Vector2d& p) {
    const Eigen::Vector3d ray = RayOf(camera, p), eye = camera.center();
    return 1 - (eye - eye.z() / ray.z() * ray).norm();
  });
  EXPECT_GT(missing, 0);
  EXPECT_LT(missing, 0.6 * spacing);
  EXPECT_EQ(splatter.outline().points.cols(), splatter.outline().segments.cols());  // closed
  EXPECT_TRUE(target.depth.empty());
  EXPECT_TRUE(target.normals.empty());
}

TEST(CloudTargetTest, ATorusKeepsItsHole) {
  const Camera camera = View();
  const PointCloud cloud = Torus(20'000, 0.75, 0.25);
  CloudSplatter splatter;
  ImageTarget target;
  splatter.Splat(cloud, Spacing(cloud), camera, &target);
  const Eigen::Vector3d hole = camera.Project({0, 0, 0}), ring = camera.Project({0.75, 0, 0});
  const auto at = [&](const Eigen::Vector3d& p) {
    return *target.silhouette.at(static_cast<int>(std::lround(p[0])),
                                 static_cast<int>(std::lround(p[1])));
  };
  EXPECT_EQ(at(hole), 0.0f);
  EXPECT_EQ(at(ring), 1.0f);
}

// Errors of depth and of normals (degrees) on the unit sphere, away from the rim.
struct SurfaceErrors {
  double depth_rms = 0, normal_rms_deg = 0, known = 0;
};
SurfaceErrors OnSphere(const ImageTarget& target) {
  const Camera& camera = target.camera;
  const Eigen::Vector3d eye = camera.center();
  SurfaceErrors errors;
  int seen = 0, known = 0;
  for (int y = 0; y < kSize; ++y) {
    for (int x = 0; x < kSize; ++x) {
      const Eigen::Vector3d ray = RayOf(camera, {x, y});
      const double a = ray.squaredNorm(), b = eye.dot(ray);
      const double root = b * b - a * (eye.squaredNorm() - 1);
      if (root < 0) {
        EXPECT_EQ(*target.depth.at(x, y), 0.0f) << x << " " << y;
        continue;
      }
      const double z = (-b - std::sqrt(root)) / a;
      const Eigen::Vector3d normal = eye + z * ray;
      if (-normal.dot(ray) < 0.3 * ray.norm()) continue;
      ++seen;
      if (*target.depth.at(x, y) == 0) continue;
      ++known;
      const Eigen::Vector3d n =
          Eigen::Map<const Eigen::Vector3f>(target.normals.at(x, y)).cast<double>();
      errors.depth_rms += std::pow(*target.depth.at(x, y) - z, 2);
      errors.normal_rms_deg +=
          std::pow(180 / M_PI * std::atan2(n.cross(normal).norm(), n.dot(normal)), 2);
    }
  }
  errors.depth_rms = std::sqrt(errors.depth_rms / known);
  errors.normal_rms_deg = std::sqrt(errors.normal_rms_deg / known);
  errors.known = static_cast<double>(known) / seen;
  return errors;
}

TEST(CloudTargetTest, DepthAndNormalsOfASphereAreExact) {
  for (const auto& [count, depth, degrees] :
       {std::tuple(100'000, 1e-4, 0.4), std::tuple(20'000, 5e-4, 1.0)}) {
    const PointCloud cloud = Sphere(count);
    CloudSplatter splatter;
    ImageTarget target;
    splatter.Splat(cloud, Spacing(cloud), View(), &target);
    const SurfaceErrors errors = OnSphere(target);
    EXPECT_LT(errors.depth_rms, depth) << count;
    EXPECT_LT(errors.normal_rms_deg, degrees) << count;
    EXPECT_GT(errors.known, 0.97) << count;
  }
}

TEST(CloudTargetTest, TheFrontSheetHidesTheOneBehindIt) {
  // Two squares facing the camera, 0.2 apart; the near one covers the left half.
  Random random(3);
  PointCloud cloud;
  cloud.points.resize(3, 60'000);
  cloud.normals.resize(3, 60'000);
  for (int i = 0; i < 60'000; ++i) {
    const bool near = i < 20'000;
    cloud.points.col(i) =
        Eigen::Vector3d(random.Uniform(-1, near ? 0 : 1), random.Uniform(-1, 1), near ? 0.2 : 0)
            .cast<float>();
    cloud.normals.col(i) << 0, 0, 1;
  }
  const Camera camera = LookAt({0, 0, 4}, {0, 0, 0}, {0, 1, 0}, 0.7, kSize);
  CloudSplatter splatter;
  ImageTarget target;
  splatter.Splat(cloud, Spacing(cloud), camera, &target);
  const double radius = 2 * Spacing(cloud) * camera.fx / 4;
  const double edge = camera.Project({0, 0, 0.2})[0];
  int near = 0, far = 0, unknown = 0;
  for (int y = 50; y < 200; ++y) {
    for (int x = 60; x < 196; ++x) {
      const double z = *target.depth.at(x, y);
      if (z == 0) {
        unknown += std::abs(x - edge) > radius + 1;
        continue;
      }
      ASSERT_TRUE(std::abs(z - 3.8) < 1e-3 || std::abs(z - 4) < 1e-3) << z;
      if (x < edge - 1) {
        ASSERT_LT(z, 3.9) << x << " " << y;
        ++near;
      } else if (x > edge + 0.5 * radius) {
        ASSERT_GT(z, 3.9) << x << " " << y;
        ++far;
      }
    }
  }
  EXPECT_GT(near, 5000);
  EXPECT_GT(far, 5000);
  EXPECT_LT(unknown, 100);
}

TEST(CloudTargetTest, WhatFacesAwayHasNoSurface) {
  PointCloud cloud = Sphere(20'000);
  cloud.normals = -cloud.normals;
  Camera camera = View();
  CloudSplatter splatter;
  ImageTarget target;
  // From outside, the far side of the inward sphere is what faces the camera.
  splatter.Splat(cloud, Spacing(cloud), camera, &target);
  const Eigen::Vector3d p = camera.Project({0, 0, 0});
  const double z =
      *target.depth.at(static_cast<int>(std::lround(p[0])), static_cast<int>(std::lround(p[1])));
  EXPECT_NEAR(z, p[2] + 1, 0.05);
}

TEST(CloudTargetTest, PointsBehindTheCameraOrFarAwayCountForNothing) {
  const PointCloud sphere = Sphere(20'000);
  const double spacing = Spacing(sphere);
  const Camera camera = View();
  PointCloud more = sphere;
  more.points.conservativeResize(3, 20'004);
  more.normals.conservativeResize(3, 20'004);
  const Eigen::Vector3d eye = camera.center();
  more.points.col(20'000) = (2 * eye).cast<float>();
  more.points.col(20'001) = eye.cast<float>();
  more.points.col(20'002) << 1e20f, 1e20f, -1e20f;
  more.points.col(20'003) << -500, 3, 1;
  more.normals.rightCols(4).colwise() = Eigen::Vector3f(0, 0, 1);
  CloudSplatter splatter;
  ImageTarget expected, target;
  splatter.Splat(sphere, spacing, camera, &expected);
  splatter.Splat(more, spacing, camera, &target);
  EXPECT_EQ(target.silhouette.values, expected.silhouette.values);
  EXPECT_EQ(target.depth.values, expected.depth.values);

  PointCloud behind = sphere;
  behind.points.colwise() += (3 * eye).cast<float>();
  splatter.Splat(behind, spacing, camera, &target);
  EXPECT_EQ(*std::max_element(target.silhouette.values.begin(), target.silhouette.values.end()), 0);
  EXPECT_EQ(*std::max_element(target.depth.values.begin(), target.depth.values.end()), 0);
}

TEST(CloudTargetTest, IsTheSameToTheBitForAnyNumberOfThreads) {
  const PointCloud cloud = Sphere(30'000);
  const double spacing = Spacing(cloud);
  CloudSplatter splatter;
  ImageTarget one, many;
  {
    tbb::global_control serial(tbb::global_control::max_allowed_parallelism, 1);
    splatter.Splat(cloud, spacing, View(), &one);
  }
  splatter.Splat(cloud, spacing, View(), &many);
  EXPECT_EQ(one.silhouette.values, many.silhouette.values);
  EXPECT_EQ(one.depth.values, many.depth.values);
  EXPECT_EQ(one.normals.values, many.normals.values);
}

TEST(CloudTargetTest, AViewFromCloseByStaysBounded) {
  // The camera is inside the cloud, points are hundreds of pixels apart.
  const PointCloud cloud = Sphere(500);
  const Camera camera = LookAt({0, 0, 0.9}, {0, 0, 1.5}, {0, 1, 0}, M_PI / 3, kSize);
  CloudSplatter splatter;
  ImageTarget target;
  splatter.Splat(cloud, Spacing(cloud), camera, &target);
  for (const float A : target.silhouette.values) ASSERT_TRUE(A >= 0 && A <= 1);
  for (const float z : target.depth.values) ASSERT_TRUE(z >= 0 && std::isfinite(z));
}

}  // namespace
}  // namespace cagefit
