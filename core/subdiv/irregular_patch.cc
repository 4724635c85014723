#include "core/subdiv/irregular_patch.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>
#include <vector>

#include "core/subdiv/loop_masks.h"

namespace cagefit {

namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr int64_t kLattice = 12;  // points of a regular child
constexpr int kMiddle = 2;        // the child that is turned by half
static_assert(kLattice % kJetSize == 0);

// Outer points, in their order behind the ring.
enum Outer { kO, kX1, kX2, kY1, kY2 };

// Points of the refined patch and, from kZ1 on, of the regular children alone: the midpoints of p
// x1, p x2, p o, q o, q y1, q y2.
enum Node {
  kV,
  kA,
  kB,
  kRp,
  kRq,
  kNo,
  kNx1,
  kNx2,
  kNy1,
  kNy2,
  kZ1,
  kZ2,
  kZ3,
  kZ4,
  kZ5,
  kZ6,
  kNodes
};

// The children (rp x2 o), (rq o y1) and (o rq rp) with their rings, in the order of box_spline.h.
constexpr Node kChildPoints[3][kLattice] = {
    {kRp, kNx2, kNo, kNx1, kZ3, kRq, kV, kA, kZ1, kZ2, kZ4, kNy1},
    {kRq, kNo, kNy1, kRp, kZ4, kNy2, kB, kV, kNx2, kZ3, kZ5, kZ6},
    {kNo, kRq, kRp, kNy1, kV, kNx2, kZ3, kZ4, kNy2, kB, kA, kNx1}};

void Add(double factor, const JetWeights& from, int count, JetWeights* to) {
  for (int k = 0; k < count; ++k) (*to)[k] += factor * from[k];
}

// Mirrored points: weight w of a + b - c.
void Mirror(int a, int b, int c, int count, JetWeights* from, JetWeights* nodes) {
  Add(1, *from, count, &nodes[a]);
  Add(1, *from, count, &nodes[b]);
  Add(-1, *from, count, &nodes[c]);
  from->fill(0);
}

// Rounding must not give derivatives a share of the constant, which would outlive them on the way
// back: rows sum to 1, those of derivatives to 0.
void RestoreSums(int count, PatchWeights* weights) {
  for (int k = 0; k < count; ++k) {
    double sum = 0;
    for (const JetWeights& w : *weights) sum += w[k];
    (*weights)[0][k] += (k == 0 ? 1 : 0) - sum;
  }
}

}  // namespace

IrregularPatch::IrregularPatch(const CornerFan& fan)
    : rule_(fan.rule),
      closed_(fan.closed),
      position_(fan.position),
      dart_(fan.dart),
      ring_size_(static_cast<int>(fan.ring.size())),
      beta_(ring_size_ >= 3 ? LoopBeta(ring_size_) : 0),
      sharp_p_(IsSharpRingEdge(position_)),
      sharp_q_(IsSharpRingEdge((position_ + 1) % ring_size_)) {
  FillTable();
}

IrregularPatch::Descent IrregularPatch::Descend(double u, double v) {
  int depth = 0;
  for (; u + v < 0.5; u *= 2, v *= 2) ++depth;
  if (u >= 0.5) return {depth, 0, 2 * u - 1, 2 * v};
  if (v >= 0.5) return {depth, 1, 2 * u, 2 * v - 1};
  return {depth, kMiddle, 1 - 2 * u, 1 - 2 * v};
}

void IrregularPatch::Evaluate(double u, double v, Derivatives derivatives,
                              PatchWeights* weights) const {
  weights->assign(point_count(), JetWeights{});
  if (IsAtVertex(u, v)) return AtVertex(derivatives, weights);

  const Descent at = Descend(u, v);
  BoxSplineWeights lattice;
  EvaluateBoxSpline(at.u, at.v, derivatives, &lattice);
  const int count = JetCount(derivatives);
  const double first = std::ldexp(at.child == kMiddle ? -1.0 : 1.0, at.depth + 1);
  const double second = std::ldexp(1.0, 2 * (at.depth + 1));
  for (JetWeights& w : lattice) {
    for (int k = 1; k < count; ++k) w[k] *= k < 3 ? first : second;
  }
  if (at.depth >= kTabled) {
    FromChild(at, lattice, count, weights);
  } else if (derivatives == Derivatives::kNone) {
    FromTable<JetCount(Derivatives::kNone)>(at, lattice, weights);
  } else if (derivatives == Derivatives::kFirst) {
    FromTable<JetCount(Derivatives::kFirst)>(at, lattice, weights);
  } else {
    FromTable<JetCount(Derivatives::kSecond)>(at, lattice, weights);
  }
}

void IrregularPatch::FromChild(const Descent& at, const BoxSplineWeights& lattice, int count,
                               PatchWeights* weights) const {
  PatchWeights fine(point_count(), JetWeights{});
  AddChild(at.child, lattice, count, &fine, weights);
  CarryBack(count, fine, weights);
  RestoreSums(count, weights);
  for (int depth = at.depth; depth > 0; --depth) {
    fine.swap(*weights);
    weights->assign(point_count(), JetWeights{});
    CarryBack(count, fine, weights);
    RestoreSums(count, weights);
  }
}

template <int count>
void IrregularPatch::FromTable(const Descent& at, const BoxSplineWeights& lattice,
                               PatchWeights* weights) const {
  const double* row = &table_[kLattice * point_count() * (3 * at.depth + at.child)];
  for (JetWeights& out : *weights) {
    std::array<double, count> sum = {};
    for (int k = 0; k < kLattice; ++k, ++row) {
      for (int c = 0; c < count; ++c) sum[c] += *row * lattice[k][c];
    }
    std::copy(sum.begin(), sum.end(), out.begin());
  }
  RestoreSums(count, weights);
}

void IrregularPatch::FillTable() {
  table_.resize(kLattice * point_count() * 3 * kTabled);
  PatchWeights weights, coarse;
  for (int child = 0; child < 3; ++child) {
    for (int64_t begin = 0; begin < kLattice; begin += kJetSize) {
      BoxSplineWeights lattice = {};
      for (int c = 0; c < kJetSize; ++c) lattice[begin + c][c] = 1;
      weights.assign(point_count(), JetWeights{});
      PatchWeights fine = weights;
      AddChild(child, lattice, kJetSize, &fine, &weights);
      CarryBack(kJetSize, fine, &weights);
      for (int depth = 0; depth < kTabled; ++depth) {
        double* const table = &table_[kLattice * point_count() * (3 * depth + child)];
        for (int j = 0; j < point_count(); ++j) {
          std::copy(weights[j].begin(), weights[j].end(), table + j * kLattice + begin);
        }
        coarse.assign(point_count(), JetWeights{});
        CarryBack(kJetSize, weights, &coarse);
        weights.swap(coarse);
      }
    }
  }
}

void IrregularPatch::AddChild(int child, const BoxSplineWeights& lattice, int count,
                              PatchWeights* fine, PatchWeights* coarse) const {
  JetWeights nodes[kNodes] = {};
  for (int k = 0; k < kLattice; ++k) Add(1, lattice[k], count, &nodes[kChildPoints[child][k]]);
  if (sharp_p_) {
    Mirror(kRp, kV, kRq, count, &nodes[kA], nodes);
    Mirror(kRp, kNx2, kNo, count, &nodes[kNx1], nodes);
    Mirror(kNx2, kZ2, kZ3, count, &nodes[kZ1], nodes);
  } else {
    Add(1, nodes[kA], count, &(*fine)[a()]);
  }
  if (sharp_q_) {
    Mirror(kRq, kV, kRp, count, &nodes[kB], nodes);
    Mirror(kRq, kNy1, kNo, count, &nodes[kNy2], nodes);
    Mirror(kNy1, kZ5, kZ4, count, &nodes[kZ6], nodes);
  } else {
    Add(1, nodes[kB], count, &(*fine)[b()]);
  }
  Add(1, nodes[kV], count, &(*fine)[0]);
  Add(1, nodes[kRp], count, &(*fine)[p()]);
  Add(1, nodes[kRq], count, &(*fine)[q()]);
  for (int k = kO; k <= kY2; ++k) Add(1, nodes[kNo + k], count, &(*fine)[outer(k)]);

  const auto edge = [&](Node node, int end_0, int end_1, int opposite_0, int opposite_1,
                        bool sharp) {
    const JetWeights& w = nodes[node];
    for (const int end : {end_0, end_1}) {
      Add(sharp ? 0.5 : kEdgeEndWeight, w, count, &(*coarse)[end]);
    }
    if (sharp) return;
    for (const int opposite : {opposite_0, opposite_1}) {
      Add(kEdgeOppositeWeight, w, count, &(*coarse)[opposite]);
    }
  };
  const int o = outer(kO), x1 = outer(kX1), x2 = outer(kX2), y1 = outer(kY1), y2 = outer(kY2);
  if (!sharp_p_) edge(kZ1, p(), x1, a(), x2, false);
  edge(kZ2, p(), x2, x1, o, sharp_p_);
  edge(kZ3, p(), o, x2, q(), false);
  edge(kZ4, q(), o, p(), y1, false);
  edge(kZ5, q(), y1, o, y2, sharp_q_);
  if (!sharp_q_) edge(kZ6, q(), y2, y1, b(), false);
}

void IrregularPatch::CarryBack(int count, const PatchWeights& fine, PatchWeights* coarse) const {
  const auto add = [&](double factor, int from, int to) {
    Add(factor, fine[from], count, &(*coarse)[to]);
  };
  const int m = ring_size_;
  switch (rule_) {
    case VertexRule::kSmooth: {
      add(1 - m * beta_, 0, 0);
      for (int k = 1; k <= m; ++k) add(beta_, 0, k);
      break;
    }
    case VertexRule::kCrease:
      add(kCurveVertexWeight, 0, 0);
      add(kCurveNeighborWeight, 0, 1);
      add(kCurveNeighborWeight, 0, m);
      break;
    case VertexRule::kCorner:
      add(1, 0, 0);
      break;
  }
  for (int k = 0; k < m; ++k) {
    const int ring = 1 + k;
    if (IsSharpRingEdge(k)) {
      add(0.5, ring, 0);
      add(0.5, ring, ring);
      continue;
    }
    add(kEdgeEndWeight, ring, 0);
    add(kEdgeEndWeight, ring, ring);
    add(kEdgeOppositeWeight, ring, 1 + (k + m - 1) % m);
    add(kEdgeOppositeWeight, ring, 1 + (k + 1) % m);
  }
  // o' is the midpoint of p q; x2' and y1' are p and q refined; x1' and y2' midpoints of p a, q b.
  const int o = outer(kO);
  for (const int end : {p(), q()}) add(kEdgeEndWeight, o, end);
  for (const int opposite : {0, o}) add(kEdgeOppositeWeight, o, opposite);
  const auto side = [&](bool sharp, int corner, int other, int beside, int near, int far) {
    if (sharp) {
      add(kCurveVertexWeight, far, corner);
      add(kCurveNeighborWeight, far, 0);
      add(kCurveNeighborWeight, far, far);
      return;
    }
    add(5.0 / 8, far, corner);
    for (const int ring : {0, other, o, far, near, beside}) add(1.0 / 16, far, ring);
    for (const int end : {corner, beside}) add(kEdgeEndWeight, near, end);
    for (const int opposite : {0, near}) add(kEdgeOppositeWeight, near, opposite);
  };
  side(sharp_p_, p(), q(), sharp_p_ ? kNoPoint : a(), outer(kX1), outer(kX2));
  side(sharp_q_, q(), p(), sharp_q_ ? kNoPoint : b(), outer(kY2), outer(kY1));
}

// Limit masks: Loop's for a smooth vertex, the curve's on creases.
void IrregularPatch::AtVertex(Derivatives derivatives, PatchWeights* weights) const {
  PatchWeights& w = *weights;
  const int m = ring_size_;
  if (rule_ == VertexRule::kCorner) {
    w[0][0] = 1;
  } else if (rule_ == VertexRule::kCrease) {
    w[0][0] = kCurveLimitVertexWeight;
    w[1][0] = w[m][0] = kCurveLimitNeighborWeight;
  } else if (dart_ >= 0) {
    const std::vector<double> ring = LoopDartLimitWeights(m);
    for (int k = 0; k < m; ++k) w[1 + (dart_ + k) % m][0] = ring[k];
    w[0][0] = 1 - std::accumulate(ring.begin(), ring.end(), 0.0);
  } else {
    for (int k = 0; k < m; ++k) w[1 + k][0] = LoopLimitWeight(m);
    w[0][0] = 1 - m * LoopLimitWeight(m);
  }
  if (derivatives == Derivatives::kNone) return;

  if (rule_ == VertexRule::kCorner) {
    // Of one or two triangles: the sharp edges. More have no tangent plane.
    const bool is_narrow = m <= 3;
    w[is_narrow ? 1 : p()][1] = w[is_narrow ? m : q()][2] = 1;
    w[0][1] = w[0][2] = -1;
  } else if (rule_ == VertexRule::kCrease) {
    AddCreaseTangents(weights);
  } else if (dart_ >= 0) {
    AddDartTangents(weights);
  } else {
    for (int k = 0; k < m; ++k) {
      w[1 + k][1] = std::cos(2 * kPi * k / m);
      w[1 + k][2] = std::sin(2 * kPi * k / m);
    }
  }
  if (derivatives == Derivatives::kFirst) return;
  for (JetWeights& point : w) {
    std::fill(point.begin() + 3, point.end(), std::numeric_limits<double>::quiet_NaN());
  }
}

// Left eigenvectors of the refinement of v and its ring e_0 .. e_s, s triangles on this side. Those
// about the curve alone: e_0 - e_s with eigenvalue 1/2 and e_0 - 2 v + e_s with 1/4. Those about
// the inside, j = 1, 2, ...: sin(j k pi / s) at e_k, with eigenvalue 3/8 + cos(j pi / s) / 4 and
// what follows for v and the ends. The two largest eigenvalues count: from 7 triangles on, j = 2
// comes before the curve. (The mask of [hoppe1994] across a crease belongs to other rules of
// refinement.)
void IrregularPatch::AddCreaseTangents(PatchWeights* weights) const {
  PatchWeights& w = *weights;
  const int m = ring_size_, s = m - 1;
  const double theta = kPi / s;
  if (s <= 6) {
    w[1][1] = 1;
    w[m][1] = -1;
  } else {
    w[1][1] = std::sin(2 * theta) / (2 * std::cos(2 * theta) - 1);
    w[m][1] = -w[1][1];
    for (int k = 1; k < s; ++k) w[1 + k][1] = std::sin(2 * k * theta);
  }
  if (s == 1) {
    w[1][2] = w[2][2] = 1;
    w[0][2] = -2;
    return;
  }
  const double lambda = 3.0 / 8 + std::cos(theta) / 4;
  const double end = (3.0 / 8 / std::tan(theta / 2) + (lambda - 0.75) * std::sin(theta)) /
                     (8 * (lambda - 1) * (lambda - 0.25));
  w[1][2] = w[m][2] = end;
  w[0][2] = 8 * (lambda - 0.5) * end - std::sin(theta);
  for (int k = 1; k < s; ++k) w[1 + k][2] = std::sin(k * theta);
}

// Across the crease nothing differs from a smooth vertex. Along it, the left eigenvector of the
// refinement of v and its ring with the largest eigenvalue below 1 among those that are symmetric
// about the crease, by power iteration.
void IrregularPatch::AddDartTangents(PatchWeights* weights) const {
  constexpr int kRounds = 200;
  const int m = ring_size_;
  PatchWeights row(point_count(), JetWeights{}), next;
  for (int k = 0; k < m; ++k) row[1 + k][1] = std::cos(2 * kPi * (k - dart_) / m);
  for (int round = 0; round < kRounds; ++round) {
    next.assign(point_count(), JetWeights{});
    CarryBack(2, row, &next);
    double sum = 0, largest = 0;
    for (const JetWeights& w : next) sum += w[1];
    next[0][1] -= sum;
    for (const JetWeights& w : next) largest = std::max(largest, std::abs(w[1]));
    for (JetWeights& w : next) w[1] /= largest;
    row.swap(next);
  }
  for (int k = 0; k <= m; ++k) (*weights)[k][1] = row[k][1];
  for (int k = 0; k < m; ++k) (*weights)[1 + k][2] = std::sin(2 * kPi * (k - dart_) / m);
}

}  // namespace cagefit
