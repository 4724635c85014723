// A triangle with one extraordinary vertex, evaluated by exact refinement [stam1998].
//
// Refining a triangle whose other two corners are regular gives three regular triangles and a
// smaller copy of the same patch at the extraordinary vertex. A point other than that vertex lies
// in a regular triangle after some steps; its box spline weights there, carried back step by step
// through the refinement masks, are its weights in the patch's own points. Where Stam diagonalises
// the refinement this multiplies, at a few flops a point and step, for any valence, boundary,
// crease, dart or corner. The products of the first steps are made once.
#ifndef CAGEFIT_CORE_SUBDIV_IRREGULAR_PATCH_H_
#define CAGEFIT_CORE_SUBDIV_IRREGULAR_PATCH_H_

#include <vector>

#include "absl/container/inlined_vector.h"
#include "core/subdiv/box_spline.h"
#include "core/subdiv/corner_fan.h"

namespace cagefit {

// Weights of a patch's points; those of all but very high valences without allocation.
using PatchWeights = absl::InlinedVector<JetWeights, 24>;

//       x2 --- o ---- y1        The triangle (v p q), p = ring[i], q = ring[i + 1], i the fan's
//      /  \  /  \   /  \        position. Points: 0 is v, 1 .. m its ring, then o, x1, x2, y1, y2.
//    x1 -- p --- q ---- y2      a and b belong to the ring of v; if vp is sharp, then a and x1 are
//      \  / \  /  \   /         mirror images across the curve (v p x2), which the rest determines;
//        a -- v --- b           likewise b and y2 if vq is sharp.
class IrregularPatch {
 public:
  static constexpr int kOuterPoints = 5;
  static constexpr int kNoPoint = -1;

  // What the masks depend on. Corners p and q must be regular, and on no crease but that of vp, vq.
  explicit IrregularPatch(const CornerFan& fan);

  int point_count() const { return 1 + ring_size_ + kOuterPoints; }
  int ring_size() const { return ring_size_; }
  bool sharp_p() const { return sharp_p_; }
  bool sharp_q() const { return sharp_q_; }

  // Whether the point lies so close to v that it is taken for v.
  static bool IsAtVertex(double u, double v) { return u + v < kVertexRadius; }

  // Writes the weights of the patch's points (point_count() of them) at u, v = weights of p, q;
  // those of mirrored points are 0. At v, where derivatives in u and v vanish or have no bound, du
  // and dv are two tangents that span the tangent plane, du x dv along the normal, and second
  // derivatives are not a number.
  void Evaluate(double u, double v, Derivatives derivatives, PatchWeights* weights) const;

 private:
  int p() const { return 1 + position_; }
  int q() const { return 1 + (position_ + 1) % ring_size_; }
  int outer(int k) const { return 1 + ring_size_ + k; }
  // Ring points before p and after q. Only where vp, vq is not sharp.
  int a() const { return 1 + (position_ + ring_size_ - 1) % ring_size_; }
  int b() const { return 1 + (position_ + 2) % ring_size_; }
  bool IsSharpRingEdge(int k) const { return closed_ ? k == dart_ : k == 0 || k + 1 == ring_size_; }

  static constexpr double kVertexRadius = 1e-14;  // below it a double has lost the direction from v

  static constexpr int kTabled = 6;  // depths whose products are kept

  // Where a point other than v lies: the regular child of the patch after `depth` refinements.
  struct Descent {
    int depth, child;
    double u, v;  // in the child
  };
  static Descent Descend(double u, double v);
  // Weights of the patch's points from those of the 12 points of the child.
  void FromChild(const Descent& at, const BoxSplineWeights& lattice, int count,
                 PatchWeights* weights) const;
  template <int count>
  void FromTable(const Descent& at, const BoxSplineWeights& lattice, PatchWeights* weights) const;
  void FillTable();

  void AtVertex(Derivatives derivatives, PatchWeights* weights) const;
  void AddCreaseTangents(PatchWeights* weights) const;
  void AddDartTangents(PatchWeights* weights) const;
  // Adds the weights of the child's 12 points to those of the refined patch's points (`fine`) and,
  // for points beyond these, to those of the patch's own (`coarse`).
  void AddChild(int child, const BoxSplineWeights& lattice, int count, PatchWeights* fine,
                PatchWeights* coarse) const;
  // Adds weights of the refined patch's points to those of the patch's own, by the masks.
  void CarryBack(int count, const PatchWeights& fine, PatchWeights* coarse) const;

  VertexRule rule_;
  bool closed_;
  int position_, dart_, ring_size_;
  double beta_;  // of a smooth vertex
  bool sharp_p_, sharp_q_;
  std::vector<double> table_;  // kTabled depths x 3 children x point_count() x 12
};

}  // namespace cagefit

#endif  // CAGEFIT_CORE_SUBDIV_IRREGULAR_PATCH_H_
