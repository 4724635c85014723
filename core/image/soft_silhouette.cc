#include "core/image/soft_silhouette.h"

#include <algorithm>
#include <limits>
#include <tuple>
#include <utility>

#include "core/base/parallel.h"
#include "core/image/cross2.h"

// Highway compiles this file once per instruction set.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/image/soft_silhouette.cc"  // NOLINT
// clang-format off
#include <hwy/foreach_target.h>  // must come before highway.h
#include <hwy/contrib/math/math-inl.h>
#include <hwy/highway.h>
// clang-format on

#ifndef CAGEFIT_CORE_IMAGE_SOFT_SILHOUETTE_TILE_
#define CAGEFIT_CORE_IMAGE_SOFT_SILHOUETTE_TILE_
namespace cagefit {

inline constexpr int kTileSide = 8, kTilePixels = kTileSide * kTileSide;
// 1 - A below this is 0.
inline constexpr float kSaturated = 1e-8F;

// Triangles of a tile, and what they are to its pixels.
struct SoftTile {
  const SoftSilhouette::TileTriangle* triangles;
  int count;
  float scale;  // 1 / sigma, per pixels^2
  float blur;   // pixels^2
};

// Where only some of a pixel's triangles count.
struct DepthLimit {
  const float* depth;    // per pixel of the tile
  const int32_t* index;  // in the tile, of the last triangle at that depth
};

}  // namespace cagefit
#endif  // CAGEFIT_CORE_IMAGE_SOFT_SILHOUETTE_TILE_

HWY_BEFORE_NAMESPACE();
namespace cagefit {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using D = hn::CappedTag<float, kTileSide>;
using V = hn::Vec<D>;
using M = hn::Mask<D>;

// A triangle's nearest side, seen from some pixels.
struct Nearest {
  V squared;              // distance, pixels^2
  V off, beside;          // p - c = off * inward normal + beside * direction, of the nearest side
  V share;                // t of c on that side
  M is_second, is_third;  // which side that is
  M inside, counts;
};

HWY_INLINE Nearest Measure(const SoftSilhouette::TileTriangle& triangle, V x, V y, V blur) {
  const D d;
  const V zero = hn::Zero(d);
  Nearest out;
  V least = zero;
  for (int k = 0; k < 3; ++k) {
    const SoftSilhouette::Side& side = triangle.sides[k];
    const V off = hn::MulAdd(hn::Set(d, side.line[0]), x,
                             hn::MulAdd(hn::Set(d, side.line[1]), y, hn::Set(d, side.line[2])));
    const V t = hn::MulAdd(hn::Set(d, side.along[0]), x,
                           hn::MulAdd(hn::Set(d, side.along[1]), y, hn::Set(d, side.along[2])));
    const V held = hn::Min(hn::Max(t, zero), hn::Set(d, side.length));
    const V beside = hn::Sub(t, held);
    const V squared = hn::MulAdd(off, off, hn::Mul(beside, beside));
    const V share = hn::Mul(held, hn::Set(d, side.inverse_length));
    if (k == 0) {
      least = off;
      out.squared = squared;
      out.off = off;
      out.beside = beside;
      out.share = share;
      out.is_second = out.is_third = hn::Lt(zero, zero);
      continue;
    }
    least = hn::Min(least, off);
    const M nearer = hn::Lt(squared, out.squared);
    out.squared = hn::IfThenElse(nearer, squared, out.squared);
    out.off = hn::IfThenElse(nearer, off, out.off);
    out.beside = hn::IfThenElse(nearer, beside, out.beside);
    out.share = hn::IfThenElse(nearer, share, out.share);
    if (k == 1) {
      out.is_second = nearer;
    } else {
      out.is_second = hn::AndNot(nearer, out.is_second);
      out.is_third = nearer;
    }
  }
  out.inside = hn::Gt(least, zero);
  out.counts = hn::Or(out.inside, hn::Lt(out.squared, blur));
  return out;
}

// sigmoid(s / sigma) with s negative inside.
HWY_INLINE V Factor(const Nearest& nearest, V scale) {
  const D d;
  const V s = hn::Mul(nearest.squared, scale);
  // Beyond 80 the exponential is 0 or infinite all the same.
  const V signed_s = hn::Min(hn::IfThenElse(nearest.inside, s, hn::Neg(s)), hn::Set(d, 80.0F));
  const V one = hn::Set(d, 1.0F);
  return hn::Div(one, hn::Add(one, hn::Exp(d, signed_s)));
}

// Depth at perspective-correct, clamped barycentric coordinates.
HWY_INLINE V Depth(const SoftSilhouette::TileTriangle& triangle, V x, V y) {
  const D d;
  const V zero = hn::Zero(d);
  V w[3], sum = zero, depth = zero;
  for (int k = 0; k < 3; ++k) {
    // Weight of the corner opposite to side k, up to a common factor, times 1 / z.
    const SoftSilhouette::Side& side = triangle.sides[k];
    const V off = hn::MulAdd(hn::Set(d, side.line[0]), x,
                             hn::MulAdd(hn::Set(d, side.line[1]), y, hn::Set(d, side.line[2])));
    w[k] = hn::Max(zero, hn::Mul(off, hn::Set(d, triangle.weight[k])));
    sum = hn::Add(sum, w[k]);
  }
  for (int k = 0; k < 3; ++k) {
    depth = hn::MulAdd(w[k], hn::Set(d, triangle.depth[k]), depth);
  }
  return hn::Div(depth, hn::Max(sum, hn::Set(d, 1e-20F)));
}

// Multiplies the factors of all triangles and counts them, per pixel. May stop early where all
// pixels are saturated.
void Multiply(const SoftTile& tile, bool may_stop, float* background, float* counts) {
  const D d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const V scale = hn::Set(d, tile.scale), blur = hn::Set(d, tile.blur);
  const V one = hn::Set(d, 1.0F);
  for (int k = 0; k < tile.count; ++k) {
    const SoftSilhouette::TileTriangle& triangle = tile.triangles[k];
    for (int row = triangle.row0; row <= triangle.row1; ++row) {
      const V y = hn::Set(d, static_cast<float>(row));
      for (int column = 0; column < kTileSide; column += lanes) {
        const int at = row * kTileSide + column;
        const Nearest nearest = Measure(triangle, hn::Iota(d, static_cast<float>(column)), y, blur);
        if (hn::AllFalse(d, nearest.counts)) continue;
        const V factor = hn::IfThenElse(nearest.counts, Factor(nearest, scale), one);
        hn::Store(hn::Mul(hn::Load(d, background + at), factor), d, background + at);
        hn::Store(hn::Add(hn::Load(d, counts + at), hn::IfThenElseZero(nearest.counts, one)), d,
                  counts + at);
      }
    }
    if (!may_stop || k % 16 != 15) continue;
    V most = hn::Zero(d);
    for (int at = 0; at < kTilePixels; at += lanes) {
      most = hn::Max(most, hn::Load(d, background + at));
    }
    if (hn::AllTrue(d, hn::Lt(most, hn::Set(d, kSaturated)))) return;
  }
}

// Factor and depth of every triangle at every pixel, kTilePixels each; depth is infinite where it
// does not count.
void Spread(const SoftTile& tile, float* factors, float* depths) {
  const D d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const V scale = hn::Set(d, tile.scale), blur = hn::Set(d, tile.blur);
  const V infinity = hn::Set(d, std::numeric_limits<float>::infinity());
  for (int k = 0; k < tile.count; ++k) {
    const SoftSilhouette::TileTriangle& triangle = tile.triangles[k];
    for (int at = 0; at < kTilePixels; at += lanes) {
      const V x = hn::Iota(d, static_cast<float>(at % kTileSide));
      const V y = hn::Set(d, static_cast<float>(at / kTileSide));
      const Nearest nearest = Measure(triangle, x, y, blur);
      const int64_t to = int64_t{k} * kTilePixels + at;
      hn::StoreU(Factor(nearest, scale), d, factors + to);
      hn::StoreU(hn::IfThenElse(nearest.counts, Depth(triangle, x, y), infinity), d, depths + to);
    }
  }
}

// Writes sum_p seed_p dA_p/d(corner) of every triangle; seed_p holds dE/dA (1 - A).
void Gradients(const SoftTile& tile, const float* seeds, const DepthLimit* limit,
               std::array<float, 6>* gradients) {
  const D d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const V scale = hn::Set(d, tile.scale), blur = hn::Set(d, tile.blur);
  const V zero = hn::Zero(d), one = hn::Set(d, 1.0F), minus_two = hn::Set(d, -2.0F);
  for (int k = 0; k < tile.count; ++k) {
    const SoftSilhouette::TileTriangle& triangle = tile.triangles[k];
    V sums[6] = {zero, zero, zero, zero, zero, zero};
    for (int row = triangle.row0; row <= triangle.row1; ++row) {
      const V y = hn::Set(d, static_cast<float>(row));
      for (int column = 0; column < kTileSide; column += lanes) {
        const int at = row * kTileSide + column;
        const V seed = hn::Load(d, seeds + at);
        const V x = hn::Iota(d, static_cast<float>(column));
        const Nearest nearest = Measure(triangle, x, y, blur);
        M counts = hn::And(nearest.counts, hn::Ne(seed, zero));
        if (limit != nullptr) {
          const V depth = Depth(triangle, x, y), deepest = hn::LoadU(d, limit->depth + at);
          const hn::RebindToSigned<D> di;
          const M is_early =
              hn::RebindMask(d, hn::Lt(hn::Set(di, k - 1), hn::LoadU(di, limit->index + at)));
          counts = hn::And(
              counts, hn::Or(hn::Lt(depth, deepest), hn::And(hn::Eq(depth, deepest), is_early)));
        }
        if (hn::AllFalse(d, counts)) continue;
        // dA/ds = -(1 - A) (1 - factor) / sigma, ds/dc = -2 (p - c), or 2 (p - c) inside.
        const V by_s = hn::Mul(hn::Neg(seed), hn::Mul(hn::Sub(one, Factor(nearest, scale)), scale));
        const V by_c = hn::IfThenElseZero(
            counts, hn::Mul(by_s, hn::IfThenElse(nearest.inside, hn::Neg(minus_two), minus_two)));
        const M on[3] = {hn::Not(hn::Or(nearest.is_second, nearest.is_third)), nearest.is_second,
                         nearest.is_third};
        for (int s = 0; s < 3; ++s) {
          const SoftSilhouette::Side& side = triangle.sides[s];
          const V weight = hn::IfThenElseZero(on[s], by_c);
          // p - c by components.
          const V gx =
              hn::Mul(weight, hn::MulAdd(nearest.off, hn::Set(d, side.line[0]),
                                         hn::Mul(nearest.beside, hn::Set(d, side.along[0]))));
          const V gy =
              hn::Mul(weight, hn::MulAdd(nearest.off, hn::Set(d, side.line[1]),
                                         hn::Mul(nearest.beside, hn::Set(d, side.along[1]))));
          const V rest = hn::Sub(one, nearest.share);
          const int a = 2 * s, b = 2 * ((s + 1) % 3);
          sums[a] = hn::MulAdd(rest, gx, sums[a]);
          sums[a + 1] = hn::MulAdd(rest, gy, sums[a + 1]);
          sums[b] = hn::MulAdd(nearest.share, gx, sums[b]);
          sums[b + 1] = hn::MulAdd(nearest.share, gy, sums[b + 1]);
        }
      }
    }
    for (int s = 0; s < 6; ++s) gradients[k][s] = hn::GetLane(hn::SumOfLanes(d, sums[s]));
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace cagefit
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace cagefit {

HWY_EXPORT(Multiply);
HWY_EXPORT(Spread);
HWY_EXPORT(Gradients);

namespace {

constexpr int64_t kTileGrain = 4;
// Twice the area, in normalised device coordinates.
constexpr double kLeastArea = 1e-8;

// Triangle f in the coordinates of a tile.
void Prepare(const ProjectedMesh& mesh, const Triangles& triangles, int32_t f, double left,
             double top, double least_area, double margin, SoftSilhouette::TileTriangle* out) {
  Eigen::Vector2d corners[3];
  double depths[3];
  for (int k = 0; k < 3; ++k) {
    const auto v = mesh.points.col(triangles(k, f));
    corners[k] = v.head<2>() - Eigen::Vector2d(left, top);
    depths[k] = v[2];
  }
  const double area = Cross2(corners[1] - corners[0], corners[2] - corners[0]);
  const auto [low, high] = std::minmax({corners[0][1], corners[1][1], corners[2][1]});
  out->row0 = static_cast<int32_t>(std::clamp(std::ceil(low - margin), 0.0, 1.0 * kTileSide));
  out->row1 = static_cast<int32_t>(std::clamp(std::floor(high + margin), -1.0, kTileSide - 1.0));
  for (int k = 0; k < 3; ++k) {
    const Eigen::Vector2d a = corners[k], along = corners[(k + 1) % 3] - a;
    const double length = along.norm();
    const Eigen::Vector2d u =
        length > 0 ? Eigen::Vector2d(along / length) : Eigen::Vector2d::Zero();
    const Eigen::Vector2d n = (area > 0 ? 1 : -1) * Eigen::Vector2d(-u[1], u[0]);
    SoftSilhouette::Side& side = out->sides[k];
    side = {{static_cast<float>(n[0]), static_cast<float>(n[1]), static_cast<float>(-n.dot(a))},
            {static_cast<float>(u[0]), static_cast<float>(u[1]), static_cast<float>(-u.dot(a))},
            static_cast<float>(length),
            static_cast<float>(length > 0 ? 1 / length : 0)};
    const double z = depths[(k + 2) % 3];
    out->weight[k] = static_cast<float>(length / z);
    out->depth[k] = static_cast<float>(z);
  }
  if (std::abs(area) > least_area) return;
  out->row0 = kTileSide;  // no row
  out->row1 = -1;
  for (SoftSilhouette::Side& side : out->sides) {
    // Nowhere near, nowhere inside.
    side = {{0, 0, -1e9F}, {0, 0, 0}, 0, 0};
  }
}

}  // namespace

void SoftSilhouette::Render(const ProjectedMesh& mesh, const Triangles& triangles, int width,
                            int height, const SoftSilhouetteOptions& options, Image* silhouette) {
  options_ = options;
  width_ = width;
  height_ = height;
  half_side_ = 0.5 * std::min(width, height);
  const double margin = half_side_ * std::sqrt(options.blur_radius);
  tiles_.Build(mesh, triangles, width, height, margin, /*pad=*/0, kTileSide);
  entries_.resize(tiles_.entry_count());
  background_.resize(tiles_.tile_count() * kTilePixels);
  limits_.resize(tiles_.tile_count());
  for (Limits& limits : limits_) limits.is_on = false;
  if (silhouette->width != width || silhouette->height != height || silhouette->channels != 1) {
    *silhouette = Image(width, height);
  }
  const double least_area = kLeastArea * half_side_ * half_side_;
  ParallelFor(tiles_.tile_count(), kTileGrain, [&](int64_t begin, int64_t end) {
    for (int64_t t = begin; t < end; ++t) {
      for (int32_t e = tiles_.begin(t); e < tiles_.begin(t + 1); ++e) {
        Prepare(mesh, triangles, tiles_.triangle(e), tiles_.left(t), tiles_.top(t), least_area,
                margin, &entries_[e]);
      }
      RenderTile(t);
      const int left = tiles_.left(t), top = tiles_.top(t);
      for (int y = top; y < std::min(top + kTileSide, height); ++y) {
        for (int x = left; x < std::min(left + kTileSide, width); ++x) {
          *silhouette->at(x, y) =
              1 - background_[t * kTilePixels + (y - top) * kTileSide + (x - left)];
        }
      }
    }
  });
}

SoftTile SoftSilhouette::TileOf(int64_t t) const {
  SoftTile tile;
  tile.triangles = entries_.data() + tiles_.begin(t);
  tile.count = tiles_.begin(t + 1) - tiles_.begin(t);
  tile.scale = static_cast<float>(1 / (options_.sigma * half_side_ * half_side_));
  tile.blur = static_cast<float>(options_.blur_radius * half_side_ * half_side_);
  return tile;
}

void SoftSilhouette::RenderTile(int64_t t) {
  const SoftTile tile = TileOf(t);
  alignas(64) float background[kTilePixels], counts[kTilePixels];
  std::fill_n(background, kTilePixels, 1.0F);
  std::fill_n(counts, kTilePixels, 0.0F);
  const bool all_count = tile.count <= options_.faces_per_pixel;
  HWY_DYNAMIC_DISPATCH(Multiply)(tile, all_count, background, counts);
  const float most = *std::max_element(counts, counts + kTilePixels);
  if (most > static_cast<float>(options_.faces_per_pixel)) LimitTile(t, tile, counts, background);
  for (int p = 0; p < kTilePixels; ++p) {
    background_[t * kTilePixels + p] = background[p] < kSaturated ? 0 : background[p];
  }
}

void SoftSilhouette::LimitTile(int64_t t, const SoftTile& tile, const float* counts,
                               float* background) {
  static thread_local std::vector<float> factors, depths;
  static thread_local std::vector<std::pair<float, int32_t>> nearest;
  factors.resize(int64_t{tile.count} * kTilePixels);
  depths.resize(int64_t{tile.count} * kTilePixels);
  HWY_DYNAMIC_DISPATCH(Spread)(tile, factors.data(), depths.data());
  Limits& limits = limits_[t];
  limits.is_on = true;
  for (int p = 0; p < kTilePixels; ++p) {
    limits.depth[p] = std::numeric_limits<float>::max();
    limits.index[p] = std::numeric_limits<int32_t>::max();
    if (counts[p] <= static_cast<float>(options_.faces_per_pixel)) continue;
    nearest.clear();
    for (int32_t k = 0; k < tile.count; ++k) {
      const float depth = depths[int64_t{k} * kTilePixels + p];
      if (std::isfinite(depth)) nearest.emplace_back(depth, k);
    }
    // Indices in the tile are in the order of faces.
    const auto last = nearest.begin() + options_.faces_per_pixel - 1;
    std::nth_element(nearest.begin(), last, nearest.end());
    std::tie(limits.depth[p], limits.index[p]) = *last;
    std::sort(nearest.begin(), last);
    background[p] = 1;
    for (auto k = nearest.begin(); k <= last; ++k) {
      background[p] *= factors[int64_t{k->second} * kTilePixels + p];
    }
  }
}

void SoftSilhouette::AddGradient(const Triangles& triangles, const Image& by_silhouette,
                                 Points2d* by_vertex) {
  gradients_.resize(entries_.size());
  ParallelFor(tiles_.tile_count(), kTileGrain, [&](int64_t begin, int64_t end) {
    for (int64_t t = begin; t < end; ++t) {
      alignas(64) float seeds[kTilePixels] = {};
      bool any = false;
      const int left = tiles_.left(t), top = tiles_.top(t);
      for (int y = top; y < std::min(top + kTileSide, height_); ++y) {
        for (int x = left; x < std::min(left + kTileSide, width_); ++x) {
          const int p = (y - top) * kTileSide + (x - left);
          seeds[p] = *by_silhouette.at(x, y) * background_[t * kTilePixels + p];
          any = any || seeds[p] != 0;
        }
      }
      std::array<float, 6>* gradients = gradients_.data() + tiles_.begin(t);
      if (!any) {
        std::fill_n(gradients, tiles_.begin(t + 1) - tiles_.begin(t), std::array<float, 6>{});
        continue;
      }
      const Limits& limits = limits_[t];
      const DepthLimit limit{limits.depth.data(), limits.index.data()};
      HWY_DYNAMIC_DISPATCH(Gradients)
      (TileOf(t), seeds, limits.is_on ? &limit : nullptr, gradients);
    }
  });
  for (size_t e = 0; e < entries_.size(); ++e) {
    const std::array<float, 6>& g = gradients_[e];
    const int32_t f = tiles_.triangle(static_cast<int64_t>(e));
    for (int k = 0; k < 3; ++k) {
      by_vertex->col(triangles(k, f)) += Eigen::Vector2d(g[2 * k], g[2 * k + 1]);
    }
  }
}

}  // namespace cagefit
#endif  // HWY_ONCE
