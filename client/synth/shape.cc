#include "client/synth/shape.h"

#include <Eigen/Geometry>
#include <Eigen/LU>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"

namespace cagefit::client {
namespace {

// Half the step of the central differences: their error is about its square.
constexpr double kStep = 1e-5;

struct NamedShape {
  const char* name;
  std::unique_ptr<SynthShape> (*make)(uint64_t seed);
};
constexpr NamedShape kShapes[] = {{"tube", &MakeTube}, {"blob", &MakeBlob}};

}  // namespace

Points3d SynthShape::Vertices(double time) const {
  Points3d vertices(3, rest_.vertices.cols());
  for (int64_t v = 0; v < vertices.cols(); ++v) {
    vertices.col(v) = Move(rest_.vertices.col(v), time);
  }
  return vertices;
}

SurfacePoint SynthShape::MovePoint(const SurfacePoint& rest, double time) const {
  Eigen::Matrix3d J_moved_rest;
  for (int axis = 0; axis < 3; ++axis) {
    const Eigen::Vector3d step = kStep * Eigen::Vector3d::Unit(axis);
    J_moved_rest.col(axis) =
        (Move(rest.position + step, time) - Move(rest.position - step, time)) / (2 * kStep);
  }
  return {Move(rest.position, time),
          (J_moved_rest.inverse().transpose() * rest.normal).normalized()};
}

std::vector<std::string> ShapeNames() {
  std::vector<std::string> names;
  for (const NamedShape& shape : kShapes) names.emplace_back(shape.name);
  return names;
}

absl::StatusOr<std::unique_ptr<SynthShape>> MakeShape(const std::string& name, uint64_t seed) {
  for (const NamedShape& shape : kShapes) {
    if (name == shape.name) return shape.make(seed);
  }
  return absl::InvalidArgumentError(
      absl::StrCat("shape is \"", name, "\"; expected ", absl::StrJoin(ShapeNames(), " or ")));
}

}  // namespace cagefit::client
