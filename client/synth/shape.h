// Shapes whose motion is known: every material point keeps its parameters for good.
#ifndef CAGEFIT_CLIENT_SYNTH_SHAPE_H_
#define CAGEFIT_CLIENT_SYNTH_SHAPE_H_

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/mesh/triangle_mesh.h"

namespace cagefit::client {

// A point of a surface and its unit normal there.
struct SurfacePoint {
  Eigen::Vector3d position, normal;
};

// Immutable; thread-safe. Lengths in metres, about 1 tall; time 0 to 1 is one full period.
class SynthShape {
 public:
  virtual ~SynthShape() = default;

  // The point of the smooth surface at rest that stands for `near`, a point of rest()'s triangles.
  virtual SurfacePoint OnRest(const Eigen::Vector3d& near) const = 0;

  // Where the material point of `rest`, a point on or near the surface at rest, is at `time`.
  virtual Eigen::Vector3d Move(const Eigen::Vector3d& rest, double time) const = 0;

  // The surface at rest, vertices on it, triangles counter-clockwise from outside.
  const TriangleMesh& rest() const { return rest_; }

  // Vertices of rest() at `time`.
  Points3d Vertices(double time) const;
  // `rest` at `time`: normals go by the inverse transpose of Move's derivative.
  SurfacePoint MovePoint(const SurfacePoint& rest, double time) const;

 protected:
  explicit SynthShape(TriangleMesh rest) : rest_(std::move(rest)) {}

 private:
  TriangleMesh rest_;
};

// A cloth-like tube, open at both ends, that twists and waves.
std::unique_ptr<SynthShape> MakeTube(uint64_t seed);
// A closed shape that bends and breathes.
std::unique_ptr<SynthShape> MakeBlob(uint64_t seed);

// Names for MakeShape, in order.
std::vector<std::string> ShapeNames();
// INVALID_ARGUMENT naming the shapes that there are.
absl::StatusOr<std::unique_ptr<SynthShape>> MakeShape(const std::string& name, uint64_t seed);

}  // namespace cagefit::client

#endif  // CAGEFIT_CLIENT_SYNTH_SHAPE_H_
