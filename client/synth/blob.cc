#include <Eigen/Geometry>
#include <array>
#include <cmath>

#include "client/synth/shape.h"
#include "core/base/random.h"

namespace cagefit::client {
namespace {

constexpr double kPi = 3.14159265358979323846;
const Eigen::Vector3d kAxes(0.22, 0.22, 0.5);
constexpr int64_t kCells = 28;  // along an edge of the cube that becomes a sphere
constexpr int kBumps = 5;

// At rest an ellipsoid, its long axis along z.
class Blob : public SynthShape {
 public:
  explicit Blob(uint64_t seed) : SynthShape(Ellipsoid()) {
    Random random(seed);
    for (Bump& bump : bumps_) {
      bump.direction = random.NormalVector().normalized();
      bump.height = random.Uniform(0.06, 0.14);
      bump.sharpness = random.Uniform(3, 8);
      bump.phase = random.Uniform(0, 2 * kPi);
    }
    bend_ = random.Uniform(0.7, 1.0);
    breath_ = random.Uniform(0.05, 0.08);
    bend_direction_ = random.Uniform(0, 2 * kPi);
  }

  SurfacePoint OnRest(const Eigen::Vector3d& near) const override {
    const Eigen::Vector3d on_sphere = near.cwiseQuotient(kAxes).normalized();
    return {on_sphere.cwiseProduct(kAxes), on_sphere.cwiseQuotient(kAxes).normalized()};
  }

  Eigen::Vector3d Move(const Eigen::Vector3d& rest, double time) const override {
    const double phase = 2 * kPi * time;
    const Eigen::Vector3d on_sphere = rest.cwiseQuotient(kAxes).normalized();
    double scale = 1;
    for (const Bump& bump : bumps_) {
      const double swell = 1 + 0.3 * std::sin(phase + bump.phase);
      scale += bump.height * swell * std::exp(bump.sharpness * (on_sphere.dot(bump.direction) - 1));
    }
    Eigen::Vector3d p = scale * rest;
    // Breathing swells it across and, by less, shortens it.
    const double breath = breath_ * std::sin(2 * phase);
    p = p.cwiseProduct(Eigen::Vector3d(1 + breath, 1 + breath, 1 - 0.5 * breath));
    return Bend(p, bend_ * std::sin(phase));
  }

 private:
  struct Bump {
    Eigen::Vector3d direction = Eigen::Vector3d::UnitX();
    double height = 0, sharpness = 0, phase = 0;
  };

  // Bends the z axis to an arc of `curvature` radians per metre in the plane of bend_direction_.
  Eigen::Vector3d Bend(const Eigen::Vector3d& p, double curvature) const {
    const Eigen::Vector3d across(std::cos(bend_direction_), std::sin(bend_direction_), 0);
    const double x = p.dot(across), angle = curvature * p.z();
    // (1 - cos a)/c and sin a/c without the division by a curvature near 0.
    const double half = 0.5 * angle;
    const double sinc = half == 0 ? 1 : std::sin(half) / half;
    const double arc_x = 0.5 * curvature * p.z() * p.z() * sinc * sinc;
    const double arc_z = p.z() * sinc * std::cos(half);
    return p - x * across - p.z() * Eigen::Vector3d::UnitZ() +
           (arc_x + x * std::cos(angle)) * across +
           (arc_z - x * std::sin(angle)) * Eigen::Vector3d::UnitZ();
  }

  // A subdivided cube, pushed out to the ellipsoid.
  static TriangleMesh Ellipsoid() {
    constexpr int64_t kSide = kCells + 1;
    TriangleMesh mesh;
    mesh.vertices.resize(3, 6 * kCells * kCells + 2);
    mesh.triangles.resize(3, 12 * kCells * kCells);
    std::vector<int32_t> index(kSide * kSide * kSide, -1);
    int32_t count = 0;
    const auto vertex = [&](const Eigen::Vector3i& cell) {
      int32_t& v = index[(cell.x() * kSide + cell.y()) * kSide + cell.z()];
      if (v < 0) {
        v = count++;
        const Eigen::Vector3d at = (2.0 / kCells * cell.cast<double>()).array() - 1;
        // Equal angles instead of equal lengths keep the triangles near the corners as large.
        const Eigen::Vector3d even = (0.25 * kPi * at.array()).tan();
        mesh.vertices.col(v) = even.normalized().cwiseProduct(kAxes);
      }
      return v;
    };
    int64_t f = 0;
    for (int side = 0; side < 6; ++side) {
      const int axis = side / 2, u = (axis + 1) % 3, v = (axis + 2) % 3;
      const bool upper = side % 2 == 1;
      for (int i = 0; i < kCells; ++i) {
        for (int j = 0; j < kCells; ++j) {
          Eigen::Vector3i a = Eigen::Vector3i::Zero();
          a[axis] = upper ? kCells : 0;
          a[u] = i;
          a[v] = j;
          const Eigen::Vector3i b = a + Eigen::Vector3i::Unit(u), d = a + Eigen::Vector3i::Unit(v),
                                c = b + Eigen::Vector3i::Unit(v);
          const int32_t ia = vertex(a), ib = vertex(upper ? b : d), ic = vertex(c),
                        id = vertex(upper ? d : b);
          mesh.triangles.col(f++) << ia, ib, ic;
          mesh.triangles.col(f++) << ia, ic, id;
        }
      }
    }
    return mesh;
  }

  std::array<Bump, kBumps> bumps_;
  double bend_ = 0, breath_ = 0, bend_direction_ = 0;
};

}  // namespace

std::unique_ptr<SynthShape> MakeBlob(uint64_t seed) { return std::make_unique<Blob>(seed); }

}  // namespace cagefit::client
