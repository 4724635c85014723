#include "core/subdiv/box_spline.h"

namespace cagefit {

namespace {

// A function F of two variables m and n with its partial derivatives.
struct Partials {
  double F, m, n, mm, mn, nn;
};

// A variable with its derivatives by u and v.
struct Variable {
  double value, u, v, uu = 0, uv = 0, vv = 0;

  Variable operator+(const Variable& o) const { return {value + o.value, u + o.u, v + o.v}; }
  Variable operator*(const Variable& o) const {  // of linear ones
    return {value * o.value, u * o.value + value * o.u, v * o.value + value * o.v,
            2 * u * o.u,     u * o.v + v * o.u,         2 * v * o.v};
  }
};

// By the chain rule, divided by 12. m is linear in u and v.
void Chain(const Partials& f, const Variable& m, const Variable& n, int count, JetWeights* w) {
  constexpr double kScale = 1.0 / 12;
  (*w)[0] = kScale * f.F;
  if (count == 1) return;
  (*w)[1] = kScale * (f.m * m.u + f.n * n.u);
  (*w)[2] = kScale * (f.m * m.v + f.n * n.v);
  if (count == 3) return;
  (*w)[3] = kScale * (f.mm * m.u * m.u + 2 * f.mn * m.u * n.u + f.nn * n.u * n.u + f.n * n.uu);
  (*w)[4] =
      kScale * (f.mm * m.u * m.v + f.mn * (m.u * n.v + m.v * n.u) + f.nn * n.u * n.v + f.n * n.uv);
  (*w)[5] = kScale * (f.mm * m.v * m.v + 2 * f.mn * m.v * n.v + f.nn * n.v * n.v + f.n * n.vv);
}

// 12 times the corner's weight; s and p are the sum and the product of the other two coordinates.
Partials Corner(double s, double p) {
  const double s2 = s * s;
  return {6 - s2 * (12 - 8 * s + s2) + p * (12 - 12 * s + 2 * s2) + 2 * p * p,
          -4 * s * (6 - 6 * s + s2) + p * (4 * s - 12),
          12 - 12 * s + 2 * s2 + 4 * p,
          -24 + 48 * s - 12 * s2 + 4 * p,
          4 * s - 12,
          4};
}

// 12 times that of the point across the edge of two corners; s and p are of their coordinates.
Partials Across(double s, double p) {
  const double s2 = s * s;
  return {s2 * (2 * s - s2 + 2 * p) + 2 * p * p,
          s * (6 * s - 4 * s2 + 4 * p),
          2 * s2 + 4 * p,
          12 * s - 12 * s2 + 4 * p,
          4 * s,
          4};
}

// 12 times that of a point that only the corner with coordinate a has in its ring, on the side of
// the corner with coordinate b: a^4 + 2 a^3 b.
Partials Behind(double a, double b) {
  const double a2 = a * a;
  return {a2 * a * (a + 2 * b), a2 * (4 * a + 6 * b), 2 * a2 * a, 12 * a * (a + b), 6 * a2, 0};
}

}  // namespace

void EvaluateBoxSpline(double u, double v, Derivatives derivatives, BoxSplineWeights* weights) {
  const Variable corners[3] = {{1 - u - v, -1, -1}, {u, 1, 0}, {v, 0, 1}};
  const int count = JetCount(derivatives);
  if (count < kJetSize) weights->fill(JetWeights{});
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    const Variable &a = corners[i], &b = corners[j], &c = corners[k];
    const Variable bc_sum = b + c, bc = b * c, ab_sum = a + b, ab = a * b;
    Chain(Corner(bc_sum.value, bc.value), bc_sum, bc, count, &(*weights)[i]);
    Chain(Across(ab_sum.value, ab.value), ab_sum, ab, count, &(*weights)[3 + i]);
    // Counter-clockwise, the ring of corner i runs on from corner k's side to corner j's.
    Chain(Behind(a.value, c.value), a, c, count, &(*weights)[6 + 2 * i]);
    Chain(Behind(a.value, b.value), a, b, count, &(*weights)[7 + 2 * i]);
  }
}

}  // namespace cagefit
