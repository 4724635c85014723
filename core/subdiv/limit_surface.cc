#include "core/subdiv/limit_surface.h"

#include <tbb/enumerable_thread_specific.h>

#include <algorithm>
#include <cmath>

#include "absl/strings/str_format.h"
#include "core/base/parallel.h"
#include "core/base/status.h"
#include "core/subdiv/child_point.h"
#include "core/subdiv/refine.h"

namespace cagefit {

namespace {

constexpr int64_t kGrain = 256;   // points a chunk
constexpr double kSlack = 1e-12;  // of u, v and 1 - u - v below 0

// The ring of corner i among the 12 points of a regular patch (box_spline.h), from the next corner.
int RingPoint(int i, int k) {
  const int ring[6] = {(i + 1) % 3, (i + 2) % 3, 3 + (i + 2) % 3, 6 + 2 * i, 7 + 2 * i, 3 + i};
  return ring[(k + 6) % 6];
}

// Gives the weights of the mirrored points beside an open fan at corner i to the points that they
// mirror. The triangle is the one at `position` of three.
template <typename Weights>
void FoldMirrors(int i, int position, int count, Weights* weights) {
  const auto fold = [&](int mirrored, int end, int inner) {
    JetWeights& w = (*weights)[RingPoint(i, mirrored - position)];
    for (int k = 0; k < count; ++k) {
      (*weights)[i][k] += w[k];
      (*weights)[RingPoint(i, end - position)][k] += w[k];
      (*weights)[RingPoint(i, inner - position)][k] -= w[k];
    }
    w.fill(0);
  };
  fold(-1, 0, 1);
  fold(4, 3, 2);
}

// Weights of derivatives by u and v from those by the child's coordinates.
void ChangeParameters(const Eigen::Matrix2d& J, int count, PatchWeights* weights) {
  if (count == 1) return;
  for (JetWeights& w : *weights) {
    const double du = w[1], dv = w[2];
    w[1] = du * J(0, 0) + dv * J(1, 0);
    w[2] = du * J(0, 1) + dv * J(1, 1);
    if (count == 3) continue;
    const double duu = w[3], duv = w[4], dvv = w[5];
    const auto second = [&](int a, int b) {
      return J(0, a) * J(0, b) * duu + (J(0, a) * J(1, b) + J(1, a) * J(0, b)) * duv +
             J(1, a) * J(1, b) * dvv;
    };
    w[3] = second(0, 0);
    w[4] = second(0, 1);
    w[5] = second(1, 1);
  }
}

}  // namespace

LimitSurface::LimitSurface(const Topology& topology, const CreaseTags& tags) : topology_(topology) {
  const SharpFeatures sharp = FindSharpFeatures(topology, tags);
  Refinement fine = RefineOnce(topology, tags);
  const SharpFeatures fine_sharp = FindSharpFeatures(fine.topology, fine.tags);
  refinement_ = std::move(fine.matrix);
  for (int32_t f = 0; f < topology.triangle_count(); ++f) {
    first_patch_.push_back(static_cast<int32_t>(patches_.size()));
    const CornerFan fans[3] = {WalkCornerFan(topology, sharp, f, 0),
                               WalkCornerFan(topology, sharp, f, 1),
                               WalkCornerFan(topology, sharp, f, 2)};
    is_split_.push_back(!std::all_of(std::begin(fans), std::end(fans),
                                     [](const CornerFan& fan) { return fan.IsRegular(); }));
    if (!is_split_.back()) {
      AddPatch(fans, topology, f, 0);
      continue;
    }
    for (int32_t child = 4 * f; child < 4 * f + 4; ++child) {
      const CornerFan fine_fans[3] = {WalkCornerFan(fine.topology, fine_sharp, child, 0),
                                      WalkCornerFan(fine.topology, fine_sharp, child, 1),
                                      WalkCornerFan(fine.topology, fine_sharp, child, 2)};
      AddPatch(fine_fans, fine.topology, child, topology.vertex_count());
    }
  }
  patches_.emplace_back();
  patches_.back().begin = static_cast<int32_t>(points_.size());
}

void LimitSurface::AddPatch(const CornerFan (&fans)[3], const Topology& topology, int32_t f,
                            int32_t offset) {
  patches_.emplace_back();
  patches_.back().begin = static_cast<int32_t>(points_.size());
  if (fans[0].IsRegular()) {
    AddRegularPatch(fans, topology, f, offset);
  } else {
    AddIrregularPatch(fans, topology.triangles()(0, f), offset);
  }
}

void LimitSurface::AddRegularPatch(const CornerFan (&fans)[3], const Topology& topology, int32_t f,
                                   int32_t offset) {
  int32_t lattice[12];
  std::fill(std::begin(lattice), std::end(lattice), kMirrored);
  for (int i = 0; i < 3; ++i) {
    lattice[i] = offset + topology.triangles()(i, f);
    const std::vector<int32_t>& ring = fans[i].ring;
    for (int k = 0; k < static_cast<int>(ring.size()); ++k) {
      lattice[RingPoint(i, k - fans[i].position)] = offset + ring[k];
    }
    patches_.back().open[i] = static_cast<int8_t>(fans[i].closed ? 0 : 1 + fans[i].position);
  }
  points_.insert(points_.end(), std::begin(lattice), std::end(lattice));
}

// In the refined mesh a triangle's extraordinary vertex, if it has one, is its corner 0: the others
// are midpoints. Their rings run, from the next corner,
//   p: q v a x1 x2 o,  open: (x2 o q v);    q: v p o y1 y2 b,  open: (v p o y1).
void LimitSurface::AddIrregularPatch(const CornerFan (&fans)[3], int32_t v, int32_t offset) {
  patches_.back().shape = ShapeOf(fans[0]);
  points_.push_back(offset + v);
  for (const int32_t point : fans[0].ring) points_.push_back(offset + point);
  const std::vector<int32_t>&p = fans[1].ring, &q = fans[2].ring;
  const int32_t o = q[2];
  const int32_t x1 = fans[1].closed ? offset + p[3] : kMirrored;
  const int32_t x2 = offset + (fans[1].closed ? p[4] : p[0]);
  const int32_t y1 = offset + q[3];
  const int32_t y2 = fans[2].closed ? offset + q[4] : kMirrored;
  points_.insert(points_.end(), {offset + o, x1, x2, y1, y2});
}

int32_t LimitSurface::ShapeOf(const CornerFan& fan) {
  const std::array<int, 5> key = {static_cast<int>(fan.rule), fan.closed ? 1 : 0, fan.position,
                                  fan.dart, static_cast<int>(fan.ring.size())};
  const auto [entry, is_new] = shape_of_.emplace(key, static_cast<int32_t>(shapes_.size()));
  if (is_new) shapes_.emplace_back(fan);
  return entry->second;
}

absl::Span<const int32_t> LimitSurface::LocalWeights(const SurfacePoint& point,
                                                     Derivatives derivatives,
                                                     PatchWeights* weights) const {
  const int count = JetCount(derivatives);
  const double u = std::max(0.0, point.u), v = std::max(0.0, point.v);
  int32_t index = first_patch_[point.face];
  ChildPoint child = {0, u, v};
  const bool is_split = is_split_[point.face] != 0;
  if (is_split) {
    child = InChild(u, v);
    index += child.child;
  }
  const Patch& patch = patches_[index];
  if (patch.shape == kRegular) {
    BoxSplineWeights lattice;
    EvaluateBoxSpline(child.u, child.v, derivatives, &lattice);
    for (int i = 0; i < 3; ++i) {
      if (patch.open[i] > 0) FoldMirrors(i, patch.open[i] - 1, count, &lattice);
    }
    weights->assign(lattice.begin(), lattice.end());
    if (is_split) ChangeParameters(ChildJacobian(child.child), count, weights);
  } else {
    shapes_[patch.shape].Evaluate(child.u, child.v, derivatives, weights);
    // Tangents of the limit masks belong to no parametrisation.
    if (!IrregularPatch::IsAtVertex(child.u, child.v)) {
      ChangeParameters(ChildJacobian(child.child), count, weights);
    }
  }
  return absl::MakeConstSpan(points_).subspan(patch.begin, patches_[index + 1].begin - patch.begin);
}

void LimitSurface::ControlPoints(const Points3d& V, Points3d* control_points) const {
  const int64_t n = V.cols();
  control_points->resize(3, n + refinement_.rows());
  control_points->leftCols(n) = V;
  ParallelFor(refinement_.rows(), 32768, [&](int64_t begin, int64_t end) {
    for (int64_t i = begin; i < end; ++i) {
      Eigen::Vector3d point = Eigen::Vector3d::Zero();
      for (StencilMatrix::InnerIterator s(refinement_, i); s; ++s) {
        point += s.value() * V.col(s.col());
      }
      control_points->col(n + i) = point;
    }
  });
}

SurfaceJet LimitSurface::Evaluate(const Points3d& control_points, const SurfacePoint& point,
                                  Derivatives derivatives) const {
  PatchWeights weights;
  const absl::Span<const int32_t> points = LocalWeights(point, derivatives, &weights);
  SurfaceJet jet;
  Eigen::Vector3d* const parts[kJetSize] = {&jet.position, &jet.du,  &jet.dv,
                                            &jet.duu,      &jet.duv, &jet.dvv};
  const int count = JetCount(derivatives);
  for (size_t k = 0; k < points.size(); ++k) {
    if (points[k] == kMirrored) continue;
    const Eigen::Vector3d p = control_points.col(points[k]);
    for (int d = 0; d < count; ++d) *parts[d] += weights[k][d] * p;
  }
  return jet;
}

void LimitSurface::PositionRow(const SurfacePoint& point, SurfaceRow* row) const {
  PatchWeights weights;
  const absl::Span<const int32_t> points = LocalWeights(point, Derivatives::kNone, &weights);
  row->clear();
  for (size_t k = 0; k < points.size(); ++k) {
    if (points[k] != kMirrored) row->emplace_back(points[k], weights[k][0]);
  }
}

bool LimitSurface::IsExtraordinary(const SurfacePoint& point) const {
  if (!is_split_[point.face]) return false;
  const ChildPoint child = InChild(std::max(0.0, point.u), std::max(0.0, point.v));
  return patches_[first_patch_[point.face] + child.child].shape != kRegular &&
         IrregularPatch::IsAtVertex(child.u, child.v);
}

absl::Status LimitSurface::Check(const SurfacePoint& point, Derivatives derivatives) const {
  const double w = 1 - point.u - point.v;
  if (point.face < 0 || point.face >= face_count() ||
      !(point.u >= -kSlack && point.v >= -kSlack && w >= -kSlack)) {
    return absl::InvalidArgumentError(absl::StrFormat("(face %d, u %g, v %g) is not on the surface",
                                                      point.face, point.u, point.v));
  }
  if (derivatives != Derivatives::kSecond || !IsExtraordinary(point)) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrFormat(
      "(face %d, u %g, v %g) is an extraordinary vertex: it has no second derivatives", point.face,
      point.u, point.v));
}

namespace {

// Rows of one chunk of points, before they are put together.
struct Rows {
  std::vector<int32_t> sizes, columns;
  std::vector<JetWeights> weights;
};

// Sums weights per column; only touched columns are ever cleared.
struct ColumnSums {
  explicit ColumnSums(int64_t columns) : entry(columns, -1) {}
  std::vector<int32_t> entry;  // per column: its place in the current row, or -1
  std::vector<std::pair<int32_t, JetWeights>> row;

  void Add(int32_t column, double factor, const JetWeights& w) {
    if (entry[column] < 0) {
      entry[column] = static_cast<int32_t>(row.size());
      row.push_back({column, JetWeights{}});
    }
    JetWeights& sum = row[entry[column]].second;
    for (int k = 0; k < kJetSize; ++k) sum[k] += factor * w[k];
  }

  void Flush(Rows* rows) {
    std::sort(row.begin(), row.end(),
              [](const auto& a, const auto& b) { return a.first < b.first; });
    rows->sizes.push_back(static_cast<int32_t>(row.size()));
    for (const auto& [column, weights] : row) {
      rows->columns.push_back(column);
      rows->weights.push_back(weights);
      entry[column] = -1;
    }
    row.clear();
  }
};

StencilMatrix Assemble(const std::vector<Rows>& chunks, int64_t rows, int64_t columns, int part) {
  StencilMatrix matrix(rows, columns);
  int64_t entries = 0;
  for (const Rows& chunk : chunks) entries += static_cast<int64_t>(chunk.columns.size());
  matrix.resizeNonZeros(entries);
  int32_t* begin = matrix.outerIndexPtr();
  int32_t *column = matrix.innerIndexPtr(), at = 0;
  double* value = matrix.valuePtr();
  for (const Rows& chunk : chunks) {
    column = std::copy(chunk.columns.begin(), chunk.columns.end(), column);
    for (const JetWeights& w : chunk.weights) *value++ = w[part];
    for (const int32_t size : chunk.sizes) {
      *begin++ = at;
      at += size;
    }
  }
  *begin = at;
  return matrix;
}

}  // namespace

absl::StatusOr<SurfaceStencils> LimitSurface::Stencils(absl::Span<const SurfacePoint> points,
                                                       Derivatives derivatives) const {
  const auto m = static_cast<int64_t>(points.size());
  for (int64_t i = 0; i < m; ++i) {
    const absl::Status status = Check(points[i], derivatives);
    if (!status.ok()) {
      return absl::InvalidArgumentError(absl::StrFormat("point %d: %s", i, status.message()));
    }
  }
  const int64_t n = vertex_count();
  std::vector<Rows> chunks((m + kGrain - 1) / kGrain);
  tbb::enumerable_thread_specific<ColumnSums> sums([&] { return ColumnSums(n); });
  ParallelFor(m, kGrain, [&](int64_t begin, int64_t end) {
    ColumnSums& sum = sums.local();
    PatchWeights weights;
    for (int64_t i = begin; i < end; ++i) {
      const absl::Span<const int32_t> local = LocalWeights(points[i], derivatives, &weights);
      for (size_t k = 0; k < local.size(); ++k) {
        if (local[k] == kMirrored) continue;
        if (local[k] < n) {
          sum.Add(local[k], 1, weights[k]);
          continue;
        }
        for (StencilMatrix::InnerIterator s(refinement_, local[k] - n); s; ++s) {
          sum.Add(s.col(), s.value(), weights[k]);
        }
      }
      sum.Flush(&chunks[begin / kGrain]);
    }
  });
  SurfaceStencils out;
  StencilMatrix* const parts[kJetSize] = {&out.position, &out.du,  &out.dv,
                                          &out.duu,      &out.duv, &out.dvv};
  for (int part = 0; part < kJetSize; ++part) {
    *parts[part] =
        part < JetCount(derivatives) ? Assemble(chunks, m, n, part) : StencilMatrix(0, n);
  }
  return out;
}

SurfacePoint LimitSurface::Across(const SurfacePoint& point, int c) const {
  const int32_t opposite = topology_.opposite(3 * point.face + c);
  if (opposite == Topology::kNone) return {};
  const double weights[3] = {1 - point.u - point.v, point.u, point.v};
  // There the edge runs the other way.
  double other[3] = {0, 0, 0};
  other[opposite % 3] = weights[(c + 1) % 3];
  other[(opposite + 1) % 3] = weights[c];
  return {opposite / 3, other[1], other[2]};
}

}  // namespace cagefit
