#include "core/cloud/imls.h"

#include <algorithm>

#include "core/cloud/field_runs.h"

// Highway compiles this file once per instruction set.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/cloud/imls.cc"  // NOLINT
#include <hwy/foreach_target.h>                  // must come before highway.h
#include <hwy/highway.h>

#ifndef CAGEFIT_CORE_CLOUD_IMLS_SUMS_
#define CAGEFIT_CORE_CLOUD_IMLS_SUMS_
namespace cagefit {

// Sums over the support, one lane group each.
enum ImlsSum {
  kPhi,    // sum phi
  kPhiC,   // sum phi c
  kPhiNx,  // sum phi n
  kPhiNy,
  kPhiNz,
  kCubeX,  // sum t^3 (x - p),  t = 1 - r^2/h^2
  kCubeY,
  kCubeZ,
  kCubeCX,  // sum t^3 c (x - p)
  kCubeCY,
  kCubeCZ,
  kCount,  // number of points with t > 0
  kMaxT,   // largest t: the nearest point
  kSums
};

struct ImlsSums {
  alignas(64) double lanes[kSums][kMaxLanes];
};

}  // namespace cagefit
#endif  // CAGEFIT_CORE_CLOUD_IMLS_SUMS_

HWY_BEFORE_NAMESPACE();
namespace cagefit {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using D = hn::CappedTag<double, kMaxLanes>;
using V = hn::Vec<D>;

void AccumulateRuns(const CellGrid& grid, const Run* runs, int count, const double* x,
                    double inverse_h2, ImlsSums* sums) {
  const D d;
  const hn::Rebind<float, D> df;
  const int64_t lanes = static_cast<int64_t>(hn::Lanes(d));
  const V one = hn::Set(d, 1.0);
  const V qx = hn::Set(d, x[0]), qy = hn::Set(d, x[1]), qz = hn::Set(d, x[2]);
  const V scale = hn::Set(d, inverse_h2);
  V acc[kSums];
  for (int s = 0; s < kSums; ++s) acc[s] = hn::Load(d, sums->lanes[s]);
  const auto load = [&](const float* p) { return hn::PromoteTo(d, hn::LoadU(df, p)); };
  for (int k = 0; k < count; ++k) {
    for (int64_t i = runs[k].begin; i < runs[k].end; i += lanes) {
      const V dx = hn::Sub(qx, load(grid.point(0) + i));
      const V dy = hn::Sub(qy, load(grid.point(1) + i));
      const V dz = hn::Sub(qz, load(grid.point(2) + i));
      const V r2 = hn::Add(hn::Add(hn::Mul(dx, dx), hn::Mul(dy, dy)), hn::Mul(dz, dz));
      V t = hn::Max(hn::Sub(one, hn::Mul(r2, scale)), hn::Zero(d));
      if (i + lanes > runs[k].end) {
        t = hn::IfThenElseZero(hn::FirstN(d, static_cast<size_t>(runs[k].end - i)), t);
      }
      if (hn::AllTrue(d, hn::Eq(t, hn::Zero(d)))) continue;
      const V nx = load(grid.normal(0) + i);
      const V ny = load(grid.normal(1) + i);
      const V nz = load(grid.normal(2) + i);
      const V c = hn::Add(hn::Add(hn::Mul(nx, dx), hn::Mul(ny, dy)), hn::Mul(nz, dz));
      const V t3 = hn::Mul(hn::Mul(t, t), t);
      const V phi = hn::Mul(t3, t);
      const V t3c = hn::Mul(t3, c);
      acc[kPhi] = hn::Add(acc[kPhi], phi);
      acc[kPhiC] = hn::Add(acc[kPhiC], hn::Mul(phi, c));
      acc[kPhiNx] = hn::Add(acc[kPhiNx], hn::Mul(phi, nx));
      acc[kPhiNy] = hn::Add(acc[kPhiNy], hn::Mul(phi, ny));
      acc[kPhiNz] = hn::Add(acc[kPhiNz], hn::Mul(phi, nz));
      acc[kCubeX] = hn::Add(acc[kCubeX], hn::Mul(t3, dx));
      acc[kCubeY] = hn::Add(acc[kCubeY], hn::Mul(t3, dy));
      acc[kCubeZ] = hn::Add(acc[kCubeZ], hn::Mul(t3, dz));
      acc[kCubeCX] = hn::Add(acc[kCubeCX], hn::Mul(t3c, dx));
      acc[kCubeCY] = hn::Add(acc[kCubeCY], hn::Mul(t3c, dy));
      acc[kCubeCZ] = hn::Add(acc[kCubeCZ], hn::Mul(t3c, dz));
      acc[kCount] = hn::Add(acc[kCount], hn::IfThenElseZero(hn::Gt(t, hn::Zero(d)), one));
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
HWY_EXPORT(AccumulateRuns);

ImlsValue EvaluateImls(const CellGrid& grid, const Eigen::Vector3d& x, double h) {
  ImlsSums sums = {};
  const double inverse_h2 = 1.0 / (h * h);
  const auto accumulate = HWY_DYNAMIC_DISPATCH(AccumulateRuns);
  ForRuns(grid, x, h, [&](const Run* runs, int count) {
    accumulate(grid, runs, count, x.data(), inverse_h2, &sums);
  });

  double total[kSums];
  for (int s = 0; s < kSums; ++s) {
    total[s] = 0;
    for (const double lane : sums.lanes[s]) {
      total[s] = s == kMaxT ? std::max(total[s], lane) : total[s] + lane;
    }
  }
  ImlsValue out;
  out.support = static_cast<int>(total[kCount]);
  // Points at the very rim have weights that underflow against nothing else: no usable field there.
  if (out.support == 0 || !(total[kPhi] > 1e-200)) {
    out.support = 0;
    return out;
  }
  const double inverse_phi = 1 / total[kPhi];
  out.value = total[kPhiC] * inverse_phi;
  const Eigen::Vector3d phi_n(total[kPhiNx], total[kPhiNy], total[kPhiNz]);
  const Eigen::Vector3d cube(total[kCubeX], total[kCubeY], total[kCubeZ]);
  const Eigen::Vector3d cube_c(total[kCubeCX], total[kCubeCY], total[kCubeCZ]);
  out.gradient = (phi_n - 8 * inverse_h2 * (cube_c - out.value * cube)) * inverse_phi;
  out.nearest = h * std::sqrt(std::max(0.0, 1 - total[kMaxT]));
  return out;
}

}  // namespace cagefit
#endif  // HWY_ONCE
