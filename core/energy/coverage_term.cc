#include "core/energy/coverage_term.h"

#include <algorithm>

#include "core/base/parallel.h"
#include "core/subdiv/child_point.h"

namespace cagefit {

namespace {

constexpr int64_t kGrain = 256;  // points a chunk

// A foot is sought again when it has moved by this many tolerances.
constexpr double kStay = 4;

// Mean edges of the control mesh.
constexpr double kReach = 2, kBoundaryReach = 1;

}  // namespace

CoverageTerm::CoverageTerm(const Topology& topology, const CreaseTags& tags, double foot_tolerance,
                           std::shared_ptr<const RefinedSurface> m1)
    : foot_tolerance_(foot_tolerance),
      surface_(topology, tags),
      m1_(m1 != nullptr ? std::move(m1) : std::make_shared<RefinedSurface>(topology, tags)),
      projector_(&surface_, tags, foot_tolerance),
      refinement_transposed_(surface_.refinement().transpose()) {}

void CoverageTerm::SetTarget(const PointCloud* target, int64_t points, double weight,
                             const RobustKernel& kernel) {
  weight_ = target != nullptr ? weight : 0;
  kernel_ = scaled_kernel_ = kernel;
  stride_ = 1;
  if (target == nullptr || !is_on()) return;
  const int64_t K = std::min(points, target->size());
  points_.resize(3, K);
  normals_.resize(3, K);
  for (int64_t k = 0; k < K; ++k) {
    points_.col(k) = target->points.col(k * target->size() / K).cast<double>();
    normals_.col(k) = target->normals.col(k * target->size() / K).cast<double>();
  }
  assigned_stride_ = 0;
  feet_.assign(K, Foot());
  chunks_.resize((K + kGrain - 1) / kGrain);
}

double CoverageTerm::PointWeight() const {
  const int64_t stride = std::max<int64_t>(1, assigned_stride_);
  const int64_t used = (points_.cols() + stride - 1) / stride;
  return weight_ * static_cast<double>(surface_.vertex_count()) /
         static_cast<double>(std::max<int64_t>(1, used));
}

double CoverageTerm::Assign(const Points3d& V) {
  if (!is_on()) return 0;
  // Later on, points that take part for the first time are sought from where their foot was at
  // first.
  if (assigned_stride_ > 0) {
    projector_.MoveVertices(V);
  } else {
    projector_.SetVertices(V);
    edge_ = MeanEdgeLength(surface_.topology(), V);
  }
  assigned_stride_ = stride_;
  return PointWeight() * ParallelSum(points_.cols(), kGrain, [&](int64_t begin, int64_t end) {
           Chunk& chunk = chunks_[begin / kGrain];
           chunk.last.swap(chunk.entries);
           chunk.entries.clear();
           double sum = 0;
           for (int64_t k = begin; k < end; ++k) {
             AssignPoint(k, &chunk);
             sum += Energy(&feet_[k]);
           }
           return sum;
         });
}

// Of the point of the surface at a foot whose row is in `entries`.
Eigen::Vector3d CoverageTerm::Offset(int64_t k, const Entries& entries,
                                     const Points3d& control_points) const {
  const Foot& foot = feet_[k];
  Eigen::Vector3d offset = points_.col(k);
  for (int32_t s = foot.begin; s < foot.begin + foot.count; ++s) {
    offset -= entries[s].second * control_points.col(entries[s].first);
  }
  return offset;
}

double CoverageTerm::EdgeLength(int32_t face) const {
  const Points3d& V = projector_.control_points();
  const auto corners = surface_.topology().triangles().col(face);
  return (V.col(corners(1)) - V.col(corners(0))).norm();
}

// A foot stays while the point is off along the normal that it was found with.
bool CoverageTerm::Stays(int64_t k, const Chunk& chunk) {
  Foot& foot = feet_[k];
  if (!foot.is_free) return false;
  const Eigen::Vector3d offset = Offset(k, chunk.last, projector_.control_points());
  const double distance = foot.direction.dot(offset);
  const double edge = EdgeLength(foot.at.face);
  if ((offset - distance * foot.direction).norm() > kStay * foot_tolerance_ * edge) return false;
  foot.residual = distance;
  return true;
}

void CoverageTerm::AssignPoint(int64_t k, Chunk* chunk) {
  Foot& foot = feet_[k];
  const bool takes_part = k % stride_ == 0;
  const auto end = static_cast<int32_t>(chunk->entries.size());
  if (takes_part && foot.used && Stays(k, *chunk)) {
    const auto row = chunk->last.begin() + foot.begin;
    chunk->entries.insert(chunk->entries.end(), row, row + foot.count);
    foot.begin = end;
    return;
  }
  foot.used = false;
  if (!takes_part) return;
  const Eigen::Vector3d p = points_.col(k);
  const SurfaceFoot found =
      foot.at.face >= 0 ? projector_.Track(p, foot.at) : projector_.Closest(p);
  foot.at = found.at;
  const bool is_off_boundary = found.on_boundary && !found.is_free;
  const bool is_beyond = found.distance > (is_off_boundary ? kBoundaryReach : kReach) * edge_;
  foot.used = normals_.col(k).dot(found.normal) > 0 && !is_beyond;
  if (!foot.used) return;
  const Eigen::Vector3d offset = p - found.position;
  foot.is_free = found.is_free && !found.on_boundary;
  foot.direction =
      foot.is_free || found.distance == 0 ? found.normal : (offset / found.distance).eval();
  foot.residual = foot.direction.dot(offset);
  SurfaceRow row;
  surface_.PositionRow(found.at, &row);
  foot.begin = end;
  foot.count = static_cast<int32_t>(row.size());
  chunk->entries.insert(chunk->entries.end(), row.begin(), row.end());
  const ChildPoint child = InChild(found.at.u, found.at.v);
  foot.triangle = 4 * found.at.face + child.child;
  foot.barycentric << 1 - child.u - child.v, child.u, child.v;
}

double CoverageTerm::Evaluate(const Points3d& V) {
  if (!is_on()) return 0;
  surface_.ControlPoints(V, &control_points_);
  return PointWeight() * ParallelSum(points_.cols(), kGrain, [&](int64_t begin, int64_t end) {
           const Entries& entries = chunks_[begin / kGrain].entries;
           double sum = 0;
           for (int64_t k = begin; k < end; ++k) {
             Foot& foot = feet_[k];
             if (!foot.used) continue;
             foot.residual = foot.direction.dot(Offset(k, entries, control_points_));
             sum += Energy(&foot);
           }
           return sum;
         });
}

double CoverageTerm::Energy(Foot* foot) const {
  if (!foot->used) return 0;
  return scaled_kernel_.Rho(foot->residual * foot->residual, &foot->weight);
}

// dE/dV = -2 gamma n/K sum_k rho' r_k d_k s_k, gathered at the control points of the patches and
// taken back through the refinement. One thread, so that the order of the sum is fixed.
void CoverageTerm::AddHalfGradient(Points3d* half_gradient) const {
  if (!is_on()) return;
  const int64_t n = surface_.vertex_count();
  pull_.setZero(3, n + surface_.refinement().rows());
  const double scale = -PointWeight();
  for (int64_t k = 0; k < points_.cols(); ++k) {
    const Foot& foot = feet_[k];
    if (!foot.used) continue;
    const Entries& entries = chunks_[k / kGrain].entries;
    const Eigen::Vector3d g = (scale * foot.weight * foot.residual) * foot.direction;
    for (int32_t s = foot.begin; s < foot.begin + foot.count; ++s) {
      pull_.col(entries[s].first) += entries[s].second * g;
    }
  }
  *half_gradient += pull_.leftCols(n);
  ParallelFor(n, 4096, [&](int64_t begin, int64_t end) {
    for (int64_t j = begin; j < end; ++j) {
      Eigen::Vector3d g = Eigen::Vector3d::Zero();
      for (StencilMatrix::InnerIterator s(refinement_transposed_, j); s; ++s) {
        g += s.value() * pull_.col(n + s.col());
      }
      half_gradient->col(j) += g;
    }
  });
}

void CoverageTerm::AddBlocks(SurfaceBlocks* blocks) const {
  if (!is_on()) return;
  const Topology& m1 = m1_->topology;
  const double scale = PointWeight();
  for (const Foot& foot : feet_) {
    if (!foot.used) continue;
    const Eigen::Vector3f d = foot.direction.cast<float>(), b = foot.barycentric.cast<float>();
    const Eigen::Matrix3f D = static_cast<float>(scale * foot.weight) * d * d.transpose();
    for (int c = 0; c < 3; ++c) {
      const int32_t v = m1.triangles()(c, foot.triangle);
      blocks->vertex[v] += b[c] * b[c] * D;
      blocks->lumped[v] += b[c] * D;
      blocks->edge[m1.triangle_edge(foot.triangle, c)] += b[c] * b[(c + 1) % 3] * D;
    }
  }
}

CoverageTerm::Row CoverageTerm::row(int64_t k) const {
  const Foot& foot = feet_[k];
  const Entries& entries = chunks_[k / kGrain].entries;
  return {absl::MakeConstSpan(entries).subspan(foot.begin, foot.count), foot.direction,
          points_.col(k), PointWeight()};
}

}  // namespace cagefit
