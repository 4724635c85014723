// Fits one control mesh to frame after frame. Everything that depends on connectivity is built
// once, in Create.
#ifndef CAGEFIT_CORE_FIT_FITTER_H_
#define CAGEFIT_CORE_FIT_FITTER_H_

#include <functional>
#include <memory>
#include <vector>

#include "absl/status/statusor.h"
#include "core/base/cancel.h"
#include "core/cloud/point_cloud.h"
#include "core/fit/energies.h"
#include "core/fit/fit_options.h"
#include "core/fit/frame_source.h"
#include "core/fit/normalization.h"
#include "core/mesh/control_mesh.h"
#include "core/subdiv/stencils.h"

namespace cagefit {

struct FitSummary {
  Energies initial, final;
  int start = 0;           // which of the starts was taken
  int iterations = 0;      // solver steps tried
  bool converged = false;  // relative decrease met before the iteration limit
  double radius = 0;       // h, user units
  double radius_in_spacings = 0;
  int grown_samples = 0;  // samples whose radius was doubled at least once, last iteration
  int far_samples = 0;    // samples beyond the far radius, last iteration
  int images = 0;         // views of the image loss
  int samples = 0;        // of the surface
  double noise = 0;       // standard deviation of the points off their surface, user units
  int64_t outliers = 0;   // points that were left out
  double index_ms = 0,
         solve_ms = 0;  // images are made in index_ms; by the caller's clock; 0 without one
};

// What the starts of a fit are. A template may lie elsewhere and have another size; an earlier fit
// has the target's size and roughly its shape, and may have to be turned and shifted.
enum class StartKind { kTemplate, kEarlierFit };

// Reads milliseconds; core has no clock of its own. May be empty.
using ClockFn = std::function<double()>;

// The points of the limit surface, as rows over the control vertices, that every fit of
// `template_mesh` holds to its target. Errors as of SampleStencils.
absl::StatusOr<StencilMatrix> FitSamples(const ControlMesh& template_mesh,
                                         const DistanceOptions& options);

// Not thread-safe; one user at a time. Buffers are kept from frame to frame.
class Fitter {
 public:
  // `template_mesh` in user units; `normalization` is that of the session's first target.
  static absl::StatusOr<Fitter> Create(const ControlMesh& template_mesh,
                                       const Normalization& normalization,
                                       const FitOptions& options);
  ~Fitter();
  Fitter(Fitter&&) noexcept;
  Fitter& operator=(Fitter&&) noexcept;

  // Fits to `target` (validated, with normals; user units) and writes the fitted control vertices
  // (3 x n, user units) to `*fitted`. Begins at that of `starts` (each 3 x n, user units; at least
  // one) where the energy without images is lowest, the first of equals. Each earlier fit is first
  // moved rigidly onto the target where that lowers E_dist; the template that was chosen, as a
  // whole and with its size, where that brings it much nearer (alignment.h). `source`: what
  // the frame has beside its points. A pure function of Create's arguments, `starts`, `target`,
  // `kind` and `source`. CANCELLED within one solver step; INTERNAL when the fit diverged (not
  // finite). On error *fitted is unchanged.
  absl::StatusOr<FitSummary> Fit(const PointCloud& target, const std::vector<Points3d>& starts,
                                 const CancelFn& cancelled, const ClockFn& clock, Points3d* fitted,
                                 StartKind kind = StartKind::kTemplate,
                                 const FrameSource& source = {});

  // The energies of control vertices (3 x n, user units), weighted as in a fit to `target`
  // (validated, with normals; user units; null: that of the last Fit) from `start`, whose rest mesh
  // is taken, and their gradient dE/dvertices (3 x n, 1 / user unit) unless that is null. Radius
  // and branch of every sample and the feet of covered points are chosen at `vertices`: the energy
  // is smooth but where these choices change, and the gradient exact where it is, but for the
  // weights of Field::kRimls, which it holds. A pure function of Create's arguments, `target`,
  // `start`, `vertices` and `source`; no later Fit depends on it. INVALID_ARGUMENT for vertices
  // that are not n finite ones, or a million times the first target's size away;
  // FAILED_PRECONDITION without a target; CANCELLED.
  absl::StatusOr<Energies> Evaluate(const PointCloud* target, const Points3d& start,
                                    const Points3d& vertices, const CancelFn& cancelled,
                                    Points3d* gradient, const FrameSource& source = {});

 private:
  struct State;
  explicit Fitter(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace cagefit

#endif  // CAGEFIT_CORE_FIT_FITTER_H_
