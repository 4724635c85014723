// How far images of the limit surface are from those of the target.
//
//   E_img = 2 / views sum_k 1 / pixels sum_p ( beta o_p (A_p - T_p)^2
//                                            + w_z (z_p - z'_p)^2 + w_n |n_p - n'_p|^2 )
//
// over the views k that are drawn: A the silhouette of M1's limit mesh (image/mesh_renderer.h), T
// that of the target, o 1 where it is observed; z and z' the depths, n and n' the normals of the
// nearest surfaces, at pixels where both images have one and z - z' is at most kDepthReach. The
// factor gives a weight the same meaning for 2 or 20 views.
//
// Derivatives, at held choices of triangles and edges: those of A are rows on edges
// (image/outline_silhouette.h). With b_c the barycentric weights of the hit point, n the normal of
// its triangle and d the pixel's ray with depth 1,
//
//   dz = sum_c b_c n . dQ_c / (n . d),   dn = -sum_c g_c (n . dQ_c),   g_c = grad b_c
//
// A camera that is not calibrated to the pixel would bend the surface after its own error. So the
// principal point of a view may lie up to slack_k pixels beside where its target has it: Calibrate
// moves it by a step of Gauss and Newton on the two unknowns, where that lowers E_img, and all else
// holds it.
//
// The Gauss-Newton matrix has blocks at vertices and edges of M1 (refined_surface.h): those of A
// with one direction for both ends of an edge, and, where a pixel hangs on the crossing of two
// edges, without the block between them and twice those on them, which is more. In PyTorch3D's mode
// a pixel hangs on too many triangles: there are no blocks for A.
#ifndef CAGEFIT_CORE_ENERGY_IMAGE_TERM_H_
#define CAGEFIT_CORE_ENERGY_IMAGE_TERM_H_

#include <cstdint>
#include <memory>
#include <vector>

#include "core/energy/refined_surface.h"
#include "core/image/image_target.h"
#include "core/image/mesh_renderer.h"

namespace cagefit {

struct ImageWeights {
  double silhouette = 0;  // beta
  double depth = 0;       // w_z, per unit of length squared
  double normals = 0;     // w_n
  bool any() const { return silhouette > 0 || depth > 0 || normals > 0; }
};

// Not thread-safe. Structure is built once; buffers keep their capacity.
class ImageTerm {
 public:
  // Farther off, depths belong to other sheets. Units of the vertices.
  static constexpr double kDepthReach = 0.1;

  // `per_iteration` views are drawn at a time, 0: all, from `seed`.
  ImageTerm(std::shared_ptr<const RefinedSurface> m1, const SilhouetteOptions& options,
            int per_iteration, uint64_t seed);

  // Refers to `targets`, whose cameras are in the coordinates of the vertices. None, or no weight:
  // the term is off and everything below is 0. `frame` goes into the seed of the views. All views
  // take part until others are drawn.
  void SetTarget(const std::vector<ImageTarget>* targets, const ImageWeights& weights,
                 uint64_t frame);
  bool is_on() const { return is_on_; }

  // Which views take part from now on: a function of seed, frame and iteration.
  void Draw(int64_t iteration);
  void UseAll();
  // Whether Draw leaves views out.
  bool draws() const;

  // Takes a step with the principal points of views that have slack, at V (3 x n). With the outline
  // mode's silhouettes only.
  void Calibrate(const Points3d& V);

  // Energy at V (3 x n).
  double Evaluate(const Points3d& V);
  // Adds half the gradient of the last evaluation (3 x n).
  void AddHalfGradient(Points3d* half_gradient);
  // Adds the blocks of the last evaluation.
  void AddBlocks(SurfaceBlocks* blocks) const;

  const std::shared_ptr<const RefinedSurface>& m1() const { return m1_; }

 private:
  struct View {
    Camera camera;  // the target's, its principal point moved
    MeshView rendering;
    Image residual;                       // o (A - T)
    Points3d gradient;                    // of half the energy by Q, 3 x vertices of M1
    std::vector<Eigen::Vector2d> slopes;  // of A by the principal point, per pixel; for Calibrate
    double energy = 0;
    int64_t evaluation = -1;  // in which residuals and rendering were made
  };
  // A residual of depth or normals at one pixel: of all three corners of a triangle.
  struct SurfaceRow;

  double Weight(const ImageTarget& target) const;  // 2 / (views pixels)
  double EvaluateView(size_t k);
  void CalibrateView(size_t k);
  template <typename Body>
  void ForSurfaceRows(size_t k, const Body& body) const;

  std::shared_ptr<const RefinedSurface> m1_;
  MeshEdges edges_;
  SilhouetteOptions options_;
  int per_iteration_;
  uint64_t seed_, frame_ = 0;
  const std::vector<ImageTarget>* targets_ = nullptr;
  ImageWeights weights_;
  bool is_on_ = false;
  std::vector<int32_t> drawn_;
  std::vector<View> views_;  // as many as targets
  Points3d V_, Q_, pull_;
  int64_t evaluation_ = 0;  // counts other V
};

}  // namespace cagefit

#endif  // CAGEFIT_CORE_ENERGY_IMAGE_TERM_H_
