// The energy that every solver minimises: E_dist + alpha E_reg + gamma E_cov + beta E_img +
// delta E_land + eta E_bound over the control vertices, in unit coordinates.
#ifndef CAGEFIT_CORE_FIT_OBJECTIVE_H_
#define CAGEFIT_CORE_FIT_OBJECTIVE_H_

#include <memory>
#include <vector>

#include "absl/container/inlined_vector.h"
#include "core/energy/arap_term.h"
#include "core/energy/attachments.h"
#include "core/energy/boundary_term.h"
#include "core/energy/coverage_term.h"
#include "core/energy/distance_term.h"
#include "core/energy/image_term.h"
#include "core/energy/landmark_term.h"
#include "core/energy/refined_surface.h"
#include "core/fit/energies.h"
#include "core/subdiv/stencils.h"

namespace cagefit {

// What a frame is held to. Lengths in unit coordinates.
struct ObjectiveTarget {
  const TargetIndex* index = nullptr;  // outlives the objective's use of it
  double far_radius = 0;               // d0
  Field field = Field::kImls;
  RobustKernel kernel;
  const PointCloud* covered = nullptr;  // with normals: points that the surface has to come to
  double coverage_weight = 0;           // gamma; 0: none, as without a coverage term
  double distance_weight = 1;           // of E_dist; 0: none
  const std::vector<ImageTarget>* images = nullptr;  // outlive the objective's use of them
  ImageWeights image_weights;
  uint64_t frame = 0;                       // what views are drawn by
  absl::Span<const Landmark> landmarks;     // outlives SetTarget
  double landmark_weight = 0;               // delta
  const BoundaryCurve* boundary = nullptr;  // outlives the objective's use of it
  double boundary_weight = 0;               // eta; 0: none, as without a boundary term
};

// Terms that not every objective has; each may be null.
struct OptionalTerms {
  std::unique_ptr<CoverageTerm> coverage;
  std::unique_ptr<ImageTerm> images;
  std::unique_ptr<LandmarkTerm> landmarks;
  std::unique_ptr<BoundaryTerm> boundary;
};

// Not thread-safe. Structure is built once; SetTarget and SetRest replace numbers.
class Objective {
 public:
  // S: m samples x n control vertices.
  Objective(const Topology& topology, StencilMatrix S, double arap_weight,
            OptionalTerms terms = {});

  void SetTarget(const ObjectiveTarget& target);
  void SetTarget(const TargetIndex* index, double far_radius) {
    ObjectiveTarget target;
    target.index = index;
    target.far_radius = far_radius;
    SetTarget(target);
  }
  void SetRest(const Points3d& rest) { arap_.SetRest(rest); }

  // Coarse to fine: multiplies radius and far radius by `radius_factor`, the kernel's scale by
  // `kernel_factor`, both >= 1, 1 after SetTarget; a coarse problem covers fewer points. Assign
  // must follow.
  void SetCoarseness(double radius_factor, double kernel_factor, bool is_coarse);

  // Takes a step with cameras whose calibration is not exact (energy/image_term.h) at V (3 x n);
  // a new choice or evaluation must follow.
  void Calibrate(const Points3d& V) {
    if (terms_.images != nullptr) terms_.images->Calibrate(V);
  }

  // Draws the views that take part from the next evaluation or choice on. Nothing where there are
  // no images.
  void DrawViews(int64_t iteration);
  // All views take part.
  void UseAllViews();

  // Chooses radius and branch of every sample, the foot of every covered point and where the
  // boundary is drawn to at V (3 x n), where Evaluate was last called or the target or the
  // coarseness is new, and returns the energies under that choice with half their gradient (3 x n)
  // unless that is null, as below.
  Energies Assign(const Points3d& V, Points3d* half_gradient);

  // As Assign at any V, but with the feet of the last Assign.
  Energies AssignSamples(const Points3d& V, Points3d* half_gradient);

  // As Assign at any V, but with the radii and branches of the last Assign.
  Energies AssignFeet(const Points3d& V, Points3d* half_gradient);

  // Energies at V with the choices of the last Assign, and half their gradient.
  Energies Evaluate(const Points3d& V, Points3d* half_gradient);

  // As Evaluate, at V where the objective was last evaluated or assigned: after another alpha was
  // set. Takes the distances from there.
  Energies Reevaluate(const Points3d& V, Points3d* half_gradient);

  // Of the last evaluation.
  const std::vector<SampleResiduals>& residuals() const { return residuals_; }
  const DistanceTerm& distance() const { return distance_; }
  const ArapTerm& arap() const { return arap_; }
  const CoverageTerm* coverage() const { return terms_.coverage.get(); }  // null: there is none
  const ImageTerm* images() const { return terms_.images.get(); }         // null: there is none
  // What landmarks and boundary come to: sets of attachments, some of them without rows.
  absl::InlinedVector<const Attachments*, 2> attachments() const;
  // Whether something was chosen that a step may leave behind: feet, or places on the boundary.
  bool has_feet() const;
  double arap_weight() const { return arap_weight_; }  // alpha
  void set_arap_weight(double weight) { arap_weight_ = weight; }
  const StencilMatrix& stencils() const { return S_; }
  // Rows at which a Gauss-Newton matrix has its blocks: the samples, and behind them, where they
  // are others, the vertices of M1 that coverage and images act on, which begin at row
  // surface_begin().
  const StencilMatrix& block_stencils() const { return surface_begin_ > 0 ? stacked_ : S_; }
  int64_t surface_begin() const { return surface_begin_; }
  // M1, or null where nothing acts on it.
  const RefinedSurface* surface() const { return surface_.get(); }
  // Whether anything acts on M1 for this target; then `blocks` are written.
  bool SurfaceBlocksOf(SurfaceBlocks* blocks) const;

 private:
  // What is not of the samples.
  void ChooseFeet(const Points3d& V);
  void EvaluateTerms(const Points3d& V);

  StencilMatrix S_, St_;       // m x n and n x m
  StencilMatrix stacked_;      // S_, then those of M1; empty where they are S_
  int64_t surface_begin_ = 0;  // 0 or m
  double arap_weight_;
  DistanceTerm distance_;
  ArapTerm arap_;
  OptionalTerms terms_;
  std::shared_ptr<const RefinedSurface> surface_;
  double radius_factor_ = 1;
  Points3d Q_;
  std::vector<SampleResiduals> residuals_;
  double distance_energy_ = 0;  // of residuals_
  double coverage_energy_ = 0, image_energy_ = 0;
};

}  // namespace cagefit

#endif  // CAGEFIT_CORE_FIT_OBJECTIVE_H_
