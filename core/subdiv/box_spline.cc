#include "core/subdiv/box_spline.h"

namespace cagefit {

namespace {

// A term of a quartic in the corners' weights a, b, c, times 12.
struct Term {
  double factor;
  int a, b, c;  // powers, 4 in sum
};

// The corner with weight a.
constexpr Term kCorner[] = {{6, 4, 0, 0},  {24, 3, 1, 0}, {24, 3, 0, 1}, {24, 2, 2, 0},
                            {60, 2, 1, 1}, {24, 2, 0, 2}, {8, 1, 3, 0},  {36, 1, 2, 1},
                            {36, 1, 1, 2}, {8, 1, 0, 3},  {1, 0, 4, 0},  {6, 0, 3, 1},
                            {12, 0, 2, 2}, {6, 0, 1, 3},  {1, 0, 0, 4}};
// The point across the edge of the corners with weights a and b.
constexpr Term kAcross[] = {{1, 4, 0, 0}, {6, 3, 1, 0}, {12, 2, 2, 0}, {6, 1, 3, 0}, {1, 0, 4, 0},
                            {2, 3, 0, 1}, {6, 2, 1, 1}, {6, 1, 2, 1},  {2, 0, 3, 1}};
// A point that only the corner with weight a has in its ring, on the side of the corner with
// weight b.
constexpr Term kBehind[] = {{1, 4, 0, 0}, {2, 3, 1, 0}};

// Powers of one weight with their derivatives, to which the constants of differentiation belong.
struct Powers {
  double p[5], d[5], dd[5];

  explicit Powers(double x) {
    p[0] = 1;
    for (int k = 1; k < 5; ++k) p[k] = p[k - 1] * x;
    for (int k = 0; k < 5; ++k) {
      d[k] = k > 0 ? k * p[k - 1] : 0;
      dd[k] = k > 1 ? k * (k - 1) * p[k - 2] : 0;
    }
  }
};

// Value, gradient and second derivatives (aa, ab, ac, bb, bc, cc) of a quartic in (a, b, c).
struct Quartic {
  double value = 0, a = 0, b = 0, c = 0, aa = 0, ab = 0, ac = 0, bb = 0, bc = 0, cc = 0;
};

template <size_t kTerms>
Quartic Evaluate(const Term (&terms)[kTerms], const Powers& a, const Powers& b, const Powers& c,
                 Derivatives derivatives) {
  Quartic q;
  for (const Term& t : terms) {
    const double f = t.factor / 12;
    const double pa = a.p[t.a], pb = b.p[t.b], pc = c.p[t.c];
    q.value += f * pa * pb * pc;
    if (derivatives == Derivatives::kNone) continue;
    const double da = a.d[t.a], db = b.d[t.b], dc = c.d[t.c];
    q.a += f * da * pb * pc;
    q.b += f * pa * db * pc;
    q.c += f * pa * pb * dc;
    if (derivatives == Derivatives::kFirst) continue;
    q.aa += f * a.dd[t.a] * pb * pc;
    q.bb += f * pa * b.dd[t.b] * pc;
    q.cc += f * pa * pb * c.dd[t.c];
    q.ab += f * da * db * pc;
    q.ac += f * da * pb * dc;
    q.bc += f * pa * db * dc;
  }
  return q;
}

// By the chain rule: (da/du, db/du, dc/du) = du and likewise dv, constants.
JetWeights Chain(const Quartic& q, const Eigen::Vector3d& du, const Eigen::Vector3d& dv) {
  const Eigen::Vector3d g(q.a, q.b, q.c);
  Eigen::Matrix3d H;
  H << q.aa, q.ab, q.ac, q.ab, q.bb, q.bc, q.ac, q.bc, q.cc;
  return {q.value, g.dot(du), g.dot(dv), du.dot(H * du), du.dot(H * dv), dv.dot(H * dv)};
}

}  // namespace

void EvaluateBoxSpline(double u, double v, Derivatives derivatives, BoxSplineWeights* weights) {
  const Powers powers[3] = {Powers(1 - u - v), Powers(u), Powers(v)};
  // d(1 - u - v, u, v) / du and / dv, per corner.
  constexpr double kDu[3] = {-1, 1, 0}, kDv[3] = {-1, 0, 1};
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    const Powers &a = powers[i], &b = powers[j], &c = powers[k];
    const Eigen::Vector3d du(kDu[i], kDu[j], kDu[k]), dv(kDv[i], kDv[j], kDv[k]);
    const Eigen::Vector3d du_kj(kDu[i], kDu[k], kDu[j]), dv_kj(kDv[i], kDv[k], kDv[j]);
    (*weights)[i] = Chain(Evaluate(kCorner, a, b, c, derivatives), du, dv);
    (*weights)[3 + i] = Chain(Evaluate(kAcross, a, b, c, derivatives), du, dv);
    // Counter-clockwise, the ring of corner i runs on from corner k's side to corner j's.
    (*weights)[6 + 2 * i] = Chain(Evaluate(kBehind, a, c, b, derivatives), du_kj, dv_kj);
    (*weights)[7 + 2 * i] = Chain(Evaluate(kBehind, a, b, c, derivatives), du, dv);
  }
}

}  // namespace cagefit
