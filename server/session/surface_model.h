// Everything of a session that its template and its first target fix for good.
#ifndef CAGEFIT_SERVER_SESSION_SURFACE_MODEL_H_
#define CAGEFIT_SERVER_SESSION_SURFACE_MODEL_H_

#include "absl/status/statusor.h"
#include "core/codec/vertex_delta.h"
#include "core/fit/fitter.h"
#include "core/mesh/control_mesh.h"
#include "core/mesh/triangle_bvh.h"
#include "core/metrics/verdict.h"
#include "core/subdiv/refine.h"
#include "server/session/flip_counter.h"
#include "server/session/session_config.h"

namespace cagefit::server {

// How well a surface covers a target.
struct Judgement {
  SampledDistances distances;
  double rms_percent = 0;  // of the first target's diagonal
  Verdict verdict = Verdict::kOk;
};

// One user at a time.
class SurfaceModel {
 public:
  // Normalisation and grid come from the bounding box of the first target. INVALID_ARGUMENT when it
  // is flat to a point, or for a template that the fit cannot use.
  static absl::StatusOr<SurfaceModel> Create(const ControlMesh& template_mesh, const Box& first_box,
                                             const SessionConfig& config);

  const ControlMesh& template_mesh() const { return template_mesh_; }
  const VertexGrid& grid() const { return grid_; }  // quantum 0: the session has none
  Fitter& fitter() { return fitter_; }

  // Judges the limit surface of `vertices` (3 x n) by a sample of `target`. `input` brings what the
  // session knows: the medians and the bare share; points farther than a share of the diagonal, or
  // than the radius `h`, from the surface are uncovered.
  Judgement Judge(const PointCloud& target, const Points3d& vertices, VerdictInput input, double h);

 private:
  SurfaceModel(ControlMesh template_mesh, VertexGrid grid, double diagonal, Fitter fitter,
               LimitMesh limit, FlipCounter flips);

  ControlMesh template_mesh_;
  VertexGrid grid_;
  double diagonal_;  // of the first target
  Fitter fitter_;
  LimitMesh limit_;
  FlipCounter flips_;
  Points3d limit_points_;
  TriangleBvh bvh_;
};

}  // namespace cagefit::server

#endif  // CAGEFIT_SERVER_SESSION_SURFACE_MODEL_H_
