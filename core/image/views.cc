#include "core/image/views.h"

#include <algorithm>
#include <cmath>

namespace cagefit {

namespace {

constexpr double kRadian = M_PI / 180;
constexpr double kRoom = 1.1;  // around the object
constexpr double kTutorialDistance = 2.7, kTutorialSide = 2;

// Upwards in the image: y, but where the view is along it.
Eigen::Vector3d Up(const Eigen::Vector3d& direction) {
  return std::abs(direction[1]) < 0.99999 ? Eigen::Vector3d::UnitY() : Eigen::Vector3d::UnitZ();
}

}  // namespace

std::vector<Camera> SphereViews(int count, const Eigen::Vector3d& center, double radius, int size) {
  const double golden_angle = M_PI * (3 - std::sqrt(5.0));
  const double distance = kRoom * radius / std::sin(0.5 * kFieldOfView * kRadian);
  std::vector<Camera> views;
  for (int k = 0; k < count; ++k) {
    const double y = 1 - (2 * k + 1.0) / count, r = std::sqrt(1 - y * y);
    const Eigen::Vector3d direction(r * std::sin(k * golden_angle), y,
                                    r * std::cos(k * golden_angle));
    views.push_back(
        LookAt(center + distance * direction, center, Up(direction), kFieldOfView * kRadian, size));
  }
  return views;
}

std::vector<Camera> TutorialViews(int count, const Eigen::Vector3d& center, double longest_side,
                                  int size) {
  const double distance = kTutorialDistance * longest_side / kTutorialSide;
  std::vector<Camera> views;
  for (int k = 0; k < count; ++k) {
    const double turn = 360.0 * k / std::max(1, count - 1);
    const double e = turn * kRadian, a = (turn - 180) * kRadian;
    const Eigen::Vector3d direction(std::cos(e) * std::sin(a), std::sin(e),
                                    std::cos(e) * std::cos(a));
    views.push_back(
        LookAt(center + distance * direction, center, Up(direction), kFieldOfView * kRadian, size));
  }
  return views;
}

}  // namespace cagefit
