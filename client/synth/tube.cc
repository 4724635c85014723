#include <Eigen/Geometry>
#include <array>
#include <cmath>

#include "client/synth/shape.h"
#include "core/base/random.h"

namespace cagefit::client {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr double kHeight = 1.0, kRadius = 0.22;
constexpr int64_t kAround = 96, kAlong = 72;
constexpr int kFolds = 3;

// At rest a round barrel around the z axis, z from 0 to kHeight. It hangs from its upper end.
class Tube : public SynthShape {
 public:
  explicit Tube(uint64_t seed) : SynthShape(Barrel()) {
    Random random(seed);
    for (Fold& fold : folds_) {
      fold.around = std::floor(random.Uniform(2, 6));
      fold.along = random.Uniform(-1.5, 1.5);
      fold.depth = random.Uniform(0.05, 0.1);
      fold.phase = random.Uniform(0, 2 * kPi);
      fold.swell = random.Uniform(0, 2 * kPi);
    }
    twist_ = random.Uniform(0.5, 0.8);
    sway_ = random.Uniform(0.08, 0.12);
    sway_direction_ = random.Uniform(0, 2 * kPi);
  }

  SurfacePoint OnRest(const Eigen::Vector3d& near) const override {
    const Eigen::Vector3d normal = Eigen::Vector3d(near.x(), near.y(), 0).normalized();
    return {kRadius * normal + near.z() * Eigen::Vector3d::UnitZ(), normal};
  }

  Eigen::Vector3d Move(const Eigen::Vector3d& rest, double time) const override {
    const double phase = 2 * kPi * time;
    const double low = 1 - rest.z() / kHeight;  // 0 at the upper end, where it hangs
    const double angle = std::atan2(rest.y(), rest.x());
    double radius = std::hypot(rest.x(), rest.y()) * (1 + 0.25 * low);
    for (const Fold& fold : folds_) {
      // Folds go with the cloth, so that its twist can be seen, and grow and shrink.
      radius += kRadius * fold.depth * (0.3 + low) * (1 + 0.4 * std::sin(phase + fold.swell)) *
                std::cos(fold.around * angle + 2 * kPi * fold.along * low + fold.phase);
    }
    const double turned = angle + twist_ * low * std::sin(phase);
    // A wave that runs down the tube, and the height that a slanted piece loses.
    const double wave = sway_ * low * std::sin(phase - 2.5 * low);
    const double lift = 0.3 * wave * wave / sway_;
    return {radius * std::cos(turned) + wave * std::cos(sway_direction_),
            radius * std::sin(turned) + wave * std::sin(sway_direction_), rest.z() + lift};
  }

 private:
  struct Fold {
    double around = 0, along = 0, depth = 0, phase = 0, swell = 0;
  };

  static TriangleMesh Barrel() {
    TriangleMesh mesh;
    mesh.vertices.resize(3, kAround * (kAlong + 1));
    mesh.triangles.resize(3, 2 * kAround * kAlong);
    for (int row = 0; row <= kAlong; ++row) {
      for (int k = 0; k < kAround; ++k) {
        const double angle = 2 * kPi * k / kAround;
        mesh.vertices.col(row * kAround + k) << kRadius * std::cos(angle),
            kRadius * std::sin(angle), kHeight * row / kAlong;
      }
    }
    int64_t f = 0;
    for (int row = 0; row < kAlong; ++row) {
      for (int k = 0; k < kAround; ++k) {
        const int a = row * kAround + k, b = row * kAround + (k + 1) % kAround;
        mesh.triangles.col(f++) << a, b, b + kAround;
        mesh.triangles.col(f++) << a, b + kAround, a + kAround;
      }
    }
    return mesh;
  }

  std::array<Fold, kFolds> folds_;
  double twist_ = 0, sway_ = 0, sway_direction_ = 0;
};

}  // namespace

std::unique_ptr<SynthShape> MakeTube(uint64_t seed) { return std::make_unique<Tube>(seed); }

}  // namespace cagefit::client
