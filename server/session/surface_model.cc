#include "server/session/surface_model.h"

#include <algorithm>
#include <utility>

#include "core/base/status.h"

namespace cagefit::server {
namespace {

// One refinement step: the distances of a verdict need not be finer than the samples of the fit.
constexpr int kJudgedLevels = 1;
// Standard error of the RMS is then about 1 %.
constexpr int kJudgedPoints = 4000;
constexpr double kCoverShareOfDiagonal = 0.01;

}  // namespace

absl::StatusOr<SurfaceModel> SurfaceModel::Create(const ControlMesh& template_mesh, const Box& box,
                                                  const SessionConfig& config) {
  ASSIGN_OR_RETURN(const Normalization normalization, Normalization::FromBox(box));
  ASSIGN_OR_RETURN(Fitter fitter, Fitter::Create(template_mesh, normalization, config.fit));
  // The middle of the box: int32 reaches equally far on all sides.
  const VertexGrid grid = {0.5 * (box.min + box.max), config.quantum * box.diagonal()};
  LimitMesh limit = BuildLimitMesh(template_mesh.topology(), template_mesh.tags(), kJudgedLevels);
  Points3d template_points;
  ApplyStencils(limit.position, template_mesh.vertices(), &template_points);
  FlipCounter flips(limit.triangles, template_points);
  return SurfaceModel(template_mesh, grid, box.diagonal(), std::move(fitter), std::move(limit),
                      std::move(flips));
}

SurfaceModel::SurfaceModel(ControlMesh template_mesh, VertexGrid grid, double diagonal,
                           Fitter fitter, LimitMesh limit, FlipCounter flips)
    : template_mesh_(std::move(template_mesh)),
      grid_(grid),
      diagonal_(diagonal),
      fitter_(std::move(fitter)),
      limit_(std::move(limit)),
      flips_(std::move(flips)) {}

Judgement SurfaceModel::Judge(const PointCloud& target, const Points3d& vertices,
                              VerdictInput input, double h) {
  ApplyStencils(limit_.position, vertices, &limit_points_);
  bvh_.Build(limit_points_, limit_.triangles);
  Judgement judgement;
  judgement.distances =
      SampleDistances(target, bvh_, kJudgedPoints, std::max(h, kCoverShareOfDiagonal * diagonal_));
  judgement.rms_percent = 100 * judgement.distances.rms / diagonal_;
  input.distances = judgement.distances;
  input.diagonal = diagonal_;
  input.flipped_share = flips_.Share(limit_points_);
  judgement.verdict = cagefit::Judge(input);
  return judgement;
}

}  // namespace cagefit::server
