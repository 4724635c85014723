#include "core/cloud/rimls.h"

#include <algorithm>
#include <cmath>

#include "core/cloud/field_runs.h"

// Highway compiles this file once per instruction set.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/cloud/rimls.cc"  // NOLINT
// clang-format off: foreach_target.h must come first
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
#include <hwy/contrib/math/math-inl.h>
// clang-format on

#ifndef CAGEFIT_CORE_CLOUD_RIMLS_SUMS_
#define CAGEFIT_CORE_CLOUD_RIMLS_SUMS_
namespace cagefit {

// Sums over the support, one lane group each; vectors take three. d = x - p, r = c - f0.
enum RimlsSum {
  kW,           // sum W
  kWC,          // sum W c
  kWN,          // sum W n
  kCube = 5,    // sum e t^3 d,  t = 1 - |d|^2/h^2
  kCubeC = 8,   // sum e t^3 c d
  kWRN = 11,    // sum W r n
  kWRRN = 14,   // sum W r^2 n
  kCount = 17,  // number of points with t > 0
  kMaxT,        // largest t: the nearest point
  kSums
};

struct RimlsSums {
  alignas(64) double lanes[kSums][kMaxLanes];
};

struct RimlsQuery {
  const double* x;
  double inverse_h2;         // 1 / h^2
  double inverse_residual2;  // 1 / sigma_r^2
  double inverse_normal2;    // 1 / sigma_n^2
  const RimlsReference* reference;
};

}  // namespace cagefit
#endif  // CAGEFIT_CORE_CLOUD_RIMLS_SUMS_

HWY_BEFORE_NAMESPACE();
namespace cagefit {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using D = hn::CappedTag<double, kMaxLanes>;
using V = hn::Vec<D>;

struct V3 {
  V x, y, z;
};
HWY_INLINE V Dot(const V3& a, const V3& b) {
  return hn::Add(hn::Add(hn::Mul(a.x, b.x), hn::Mul(a.y, b.y)), hn::Mul(a.z, b.z));
}
HWY_INLINE void AddScaled(V scale, const V3& v, V* sum) {
  sum[0] = hn::Add(sum[0], hn::Mul(scale, v.x));
  sum[1] = hn::Add(sum[1], hn::Mul(scale, v.y));
  sum[2] = hn::Add(sum[2], hn::Mul(scale, v.z));
}

void AccumulateRobustRuns(const CellGrid& grid, const Run* runs, int count, const RimlsQuery& query,
                          RimlsSums* sums) {
  const D d;
  const hn::Rebind<float, D> df;
  const int64_t lanes = static_cast<int64_t>(hn::Lanes(d));
  const V zero = hn::Zero(d), one = hn::Set(d, 1.0);
  const V3 q = {hn::Set(d, query.x[0]), hn::Set(d, query.x[1]), hn::Set(d, query.x[2])};
  const Eigen::Vector3d& g0 = query.reference->gradient;
  const V3 g = {hn::Set(d, g0[0]), hn::Set(d, g0[1]), hn::Set(d, g0[2])};
  const V f0 = hn::Set(d, query.reference->value);
  const V scale = hn::Set(d, query.inverse_h2);
  const V by_residual = hn::Set(d, -query.inverse_residual2);
  const V by_normal = hn::Set(d, -query.inverse_normal2);
  V acc[kSums];
  for (int s = 0; s < kSums; ++s) acc[s] = hn::Load(d, sums->lanes[s]);
  const auto load = [&](const float* p) { return hn::PromoteTo(d, hn::LoadU(df, p)); };
  for (int k = 0; k < count; ++k) {
    for (int64_t i = runs[k].begin; i < runs[k].end; i += lanes) {
      const V3 delta = {hn::Sub(q.x, load(grid.point(0) + i)),
                        hn::Sub(q.y, load(grid.point(1) + i)),
                        hn::Sub(q.z, load(grid.point(2) + i))};
      V t = hn::Max(hn::Sub(one, hn::Mul(Dot(delta, delta), scale)), zero);
      if (i + lanes > runs[k].end) {
        t = hn::IfThenElseZero(hn::FirstN(d, static_cast<size_t>(runs[k].end - i)), t);
      }
      if (hn::AllTrue(d, hn::Eq(t, zero))) continue;
      const V3 n = {load(grid.normal(0) + i), load(grid.normal(1) + i), load(grid.normal(2) + i)};
      const V c = Dot(n, delta);
      const V r = hn::Sub(c, f0);
      const V3 turn = {hn::Sub(n.x, g.x), hn::Sub(n.y, g.y), hn::Sub(n.z, g.z)};
      // Lanes outside the support may lie far off; t = 0 keeps them out, but exp must stay finite.
      const V exponent =
          hn::Add(hn::Mul(by_residual, hn::Mul(r, r)), hn::Mul(by_normal, Dot(turn, turn)));
      const V e = hn::Exp(d, hn::Max(exponent, hn::Set(d, -700.0)));
      const V et3 = hn::Mul(e, hn::Mul(hn::Mul(t, t), t));
      const V w = hn::Mul(et3, t);
      const V wr = hn::Mul(w, r);
      acc[kW] = hn::Add(acc[kW], w);
      acc[kWC] = hn::Add(acc[kWC], hn::Mul(w, c));
      AddScaled(w, n, acc + kWN);
      AddScaled(et3, delta, acc + kCube);
      AddScaled(hn::Mul(et3, c), delta, acc + kCubeC);
      AddScaled(wr, n, acc + kWRN);
      AddScaled(hn::Mul(wr, r), n, acc + kWRRN);
      acc[kCount] = hn::Add(acc[kCount], hn::IfThenElseZero(hn::Gt(t, zero), one));
      acc[kMaxT] = hn::Max(acc[kMaxT], t);
    }
  }
  for (int s = 0; s < kSums; ++s) hn::Store(acc[s], d, sums->lanes[s]);
}

}  // namespace HWY_NAMESPACE
}  // namespace cagefit
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace cagefit {
HWY_EXPORT(AccumulateRobustRuns);

namespace {

constexpr double kResidualSigma = 0.5;  // sigma_r in radii

struct RobustField {
  ImlsValue value;
  Eigen::Vector3d held_gradient = Eigen::Vector3d::Zero();  // with e held fixed
};

RobustField Evaluate(const CellGrid& grid, const Eigen::Vector3d& x, double h,
                     const RimlsOptions& options, const RimlsReference& reference) {
  RimlsSums sums = {};
  RimlsQuery query;
  query.x = x.data();
  query.inverse_h2 = 1 / (h * h);
  query.inverse_residual2 = query.inverse_h2 / (kResidualSigma * kResidualSigma);
  query.inverse_normal2 = 1 / (options.normal_sigma * options.normal_sigma);
  query.reference = &reference;
  const auto accumulate = HWY_DYNAMIC_DISPATCH(AccumulateRobustRuns);
  ForRuns(grid, x, h,
          [&](const Run* runs, int count) { accumulate(grid, runs, count, query, &sums); });

  double total[kSums];
  for (int s = 0; s < kSums; ++s) {
    total[s] = 0;
    for (const double lane : sums.lanes[s]) {
      total[s] = s == kMaxT ? std::max(total[s], lane) : total[s] + lane;
    }
  }
  RobustField out;
  // Points at the very rim have weights that underflow against nothing else: no usable field there.
  if (!(total[kW] > 1e-200)) return out;
  const auto vector = [&](int s) { return Eigen::Map<const Eigen::Vector3d>(total + s); };
  const double inverse_w = 1 / total[kW];
  const double f = total[kWC] * inverse_w;
  out.value.support = static_cast<int>(total[kCount]);
  out.value.value = f;
  out.value.nearest = h * std::sqrt(std::max(0.0, 1 - total[kMaxT]));
  out.held_gradient =
      (vector(kWN) - 8 * query.inverse_h2 * (vector(kCubeC) - f * vector(kCube))) * inverse_w;
  // (c - f) (c - f0) = r^2 + (f0 - f) r.
  const Eigen::Vector3d through_e = vector(kWRRN) + (reference.value - f) * vector(kWRN);
  out.value.gradient = out.held_gradient - 2 * query.inverse_residual2 * inverse_w * through_e;
  return out;
}

RimlsReference Reference(double value, const Eigen::Vector3d& gradient) {
  return {value, gradient / std::max(1.0, gradient.norm())};
}

}  // namespace

RimlsReference SolveRimls(const CellGrid& grid, const Eigen::Vector3d& x, double h,
                          const RimlsOptions& options) {
  const ImlsValue start = EvaluateImls(grid, x, h);
  if (start.support == 0) return {};
  RimlsReference reference = Reference(start.value, start.gradient);
  for (int round = 0; round < options.rounds; ++round) {
    const RobustField field = Evaluate(grid, x, h, options, reference);
    if (field.value.support == 0) break;
    reference = Reference(field.value.value, field.held_gradient);
  }
  return reference;
}

ImlsValue EvaluateRimls(const CellGrid& grid, const Eigen::Vector3d& x, double h,
                        const RimlsOptions& options, const RimlsReference& reference) {
  return Evaluate(grid, x, h, options, reference).value;
}

}  // namespace cagefit
#endif  // HWY_ONCE
