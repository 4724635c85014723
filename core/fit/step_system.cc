#include "core/fit/step_system.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "core/base/parallel.h"

namespace cagefit {

namespace {

// Samples or vertices a chunk: some 50 microseconds of work. Smaller ones cost more in waking
// threads than they save.
constexpr int64_t kGrain = 1024;

using Vec = Eigen::Vector4f;

Vec Widen(const Eigen::Vector3d& x) {
  return Vec(static_cast<float>(x[0]), static_cast<float>(x[1]), static_cast<float>(x[2]), 0.0f);
}

Eigen::Matrix4f Widen(const Eigen::Matrix3d& M) {
  Eigen::Matrix4f out = Eigen::Matrix4f::Zero();
  out.topLeftCorner<3, 3>() = M.cast<float>();
  return out;
}

void CopyRows(const StencilMatrix& S, std::vector<int32_t>* begin, std::vector<int32_t>* index,
              std::vector<float>* weight) {
  begin->assign(S.outerIndexPtr(), S.outerIndexPtr() + S.rows() + 1);
  index->assign(S.innerIndexPtr(), S.innerIndexPtr() + S.nonZeros());
  weight->resize(S.nonZeros());
  std::transform(S.valuePtr(), S.valuePtr() + S.nonZeros(), weight->begin(),
                 [](double w) { return static_cast<float>(w); });
}

Vec Times(const Vec* columns, const Vec& x) {
  return columns[0] * x[0] + columns[1] * x[1] + columns[2] * x[2];
}

template <typename Vectors>
double Dot(const Vectors& a, const Vectors& b) {
  return ParallelSum(static_cast<int64_t>(a.size()), kGrain, [&](int64_t begin, int64_t end) {
    double sum = 0;
    for (int64_t i = begin; i < end; ++i) sum += static_cast<double>(a[i].dot(b[i]));
    return sum;
  });
}

}  // namespace

StepSystem::StepSystem(const Objective& objective)
    : rows_(objective.block_stencils().rows()), vertices_(objective.block_stencils().cols()) {
  CopyRows(objective.block_stencils(), &row_begin_, &row_index_, &row_weight_);
  CopyRows(objective.block_stencils().transpose(), &column_begin_, &column_index_, &column_weight_);
  const ArapTerm& arap = objective.arap();
  edge_begin_.push_back(0);
  for (int32_t i = 0; i < vertices_; ++i) {
    for (int32_t e = arap.begin(i); e < arap.begin(i + 1); ++e) {
      const int32_t j = arap.neighbor(e);
      edge_neighbor_.push_back(j);
      int32_t reverse = arap.begin(j);
      while (arap.neighbor(reverse) != i) ++reverse;
      edge_reverse_.push_back(reverse);
    }
    edge_begin_.push_back(static_cast<int32_t>(edge_neighbor_.size()));
  }
  if (objective.surface() != nullptr) LinkRows(objective);
  block_columns_.resize(3 * rows_);
  row_in_.resize(rows_);
  row_out_.resize(rows_);
  edge_weight_.resize(edge_neighbor_.size());
  edge_.resize(edge_neighbor_.size());
  edge_sum_.resize(vertices_);
  inverse_inertia_.resize(vertices_);
  inverse_diagonal_.resize(vertices_);
  diagonal_.resize(vertices_);
  for (Vecs* v : {&turn_, &x_, &r_, &z_, &p_, &q_}) v->resize(vertices_);
}

void StepSystem::LinkRows(const Objective& objective) {
  surface_begin_ = objective.surface_begin();
  const Topology& m1 = objective.surface()->topology;
  link_columns_.resize(3 * m1.edge_count());
  link_begin_.push_back(0);
  for (int32_t v = 0; v < m1.vertex_count(); ++v) {
    const absl::Span<const int32_t> ring = m1.Ring(v), edges = m1.RingEdges(v);
    for (size_t k = 0; k < ring.size(); ++k) {
      link_row_.push_back(static_cast<int32_t>(surface_begin_) + ring[k]);
      link_edge_.push_back(edges[k]);
    }
    link_begin_.push_back(static_cast<int32_t>(link_row_.size()));
  }
}

void StepSystem::Linearize(const Objective& objective) {
  LinearizeRows(objective);
  const double alpha = objective.arap_weight();
  const ArapTerm& arap = objective.arap();
  rigid_ = alpha > 0;
  ParallelFor(vertices_, kGrain, [&](int64_t begin, int64_t end) {
    for (int64_t i = begin; i < end; ++i) {
      Vec columns[3] = {Vec::Zero(), Vec::Zero(), Vec::Zero()};
      for (int32_t s = column_begin_[i]; s < column_begin_[i + 1]; ++s) {
        const float w = column_weight_[s] * column_weight_[s];
        const int32_t row = column_index_[s];
        for (int c = 0; c < 3; ++c) columns[c] += w * block_columns_[3 * row + c];
        if (linked_ && row >= surface_begin_) {
          // What the links add, as if the rows that they join moved alike.
          const int64_t v = row - surface_begin_;
          const Eigen::Matrix3f links = surface_.lumped[v] - surface_.vertex[v];
          for (int c = 0; c < 3; ++c) columns[c].head<3>() += w * links.col(c);
        }
      }
      Eigen::Matrix3d D;
      for (int c = 0; c < 3; ++c) D.col(c) = columns[c].head<3>().cast<double>();
      if (rigid_) {
        const Eigen::Matrix3d& R = arap.rotation(static_cast<int32_t>(i));
        Eigen::Vector3d edge_sum = Eigen::Vector3d::Zero();
        double weight_sum = 0;
        for (int32_t e = edge_begin_[i]; e < edge_begin_[i + 1]; ++e) {
          const double w = alpha * arap.weight(e);
          const Eigen::Vector3d a =
              w * (R * (arap.rest().col(i) - arap.rest().col(edge_neighbor_[e])));
          edge_weight_[e] = static_cast<float>(2 * w);
          edge_[e] = Widen(a);
          edge_sum += a;
          weight_sum += w;
        }
        edge_sum_[i] = Widen(edge_sum);
        inverse_inertia_[i] = Widen(Eigen::Matrix3d(
            R * arap.inverse_inertia(static_cast<int32_t>(i)) * R.transpose() / alpha));
        D.diagonal().array() += 2 * weight_sum;
      }
      diagonal_[i] = D;
    }
  });
  AddAttachments(objective);
  double trace = 0;
  for (const Eigen::Matrix3d& D : diagonal_) trace += D.trace();
  mean_diagonal_ = static_cast<float>(trace / (3.0 * static_cast<double>(vertices_)));
}

void StepSystem::LinearizeRows(const Objective& objective) {
  const auto weight = static_cast<float>(objective.distance().weight());
  const std::vector<SampleResiduals>& residuals = objective.residuals();
  const auto samples = static_cast<int64_t>(residuals.size());
  linked_ = objective.SurfaceBlocksOf(&surface_);
  if (linked_) {
    for (size_t e = 0; e < surface_.edge.size(); ++e) {
      for (int c = 0; c < 3; ++c) link_columns_[3 * e + c] << surface_.edge[e].col(c), 0;
    }
  }
  ParallelFor(rows_, kGrain, [&](int64_t begin, int64_t end) {
    for (int64_t i = begin; i < end; ++i) {
      Eigen::Matrix3f A = Eigen::Matrix3f::Zero();
      if (i < samples) {
        const SampleResiduals& r = residuals[i];
        const Eigen::Vector3f f = r.grad_f.cast<float>();
        A = static_cast<float>(r.weight) * weight * f * f.transpose();
        if (r.beyond > 0) {
          const Eigen::Vector3f b = r.grad_beyond.cast<float>();
          A += weight * b * b.transpose();
        }
      }
      if (linked_ && i >= surface_begin_) A += surface_.vertex[i - surface_begin_];
      for (int c = 0; c < 3; ++c) block_columns_[3 * i + c] << A.col(c), 0;
    }
  });
}

void StepSystem::AddAttachments(const Objective& objective) {
  attached_begin_.assign(1, 0);
  attached_index_.clear();
  attached_weight_.clear();
  attached_columns_.clear();
  for (const Attachments* set : objective.attachments()) {
    for (int64_t k = 0; k < set->size(); ++k) {
      const Eigen::Matrix3d& A = set->weights[k];
      if (A.isZero(0)) continue;
      for (StencilMatrix::InnerIterator s(set->rows, k); s; ++s) {
        attached_index_.push_back(s.col());
        attached_weight_.push_back(static_cast<float>(s.value()));
        diagonal_[s.col()] += s.value() * s.value() * A;
      }
      for (int c = 0; c < 3; ++c) attached_columns_.push_back(Widen(Eigen::Vector3d(A.col(c))));
      attached_begin_.push_back(static_cast<int32_t>(attached_index_.size()));
    }
  }
}

void StepSystem::Precondition(double damping) {
  const double shift = std::max(damping, 1e-9) * mean_diagonal_;
  for (int64_t i = 0; i < vertices_; ++i) {
    Eigen::Matrix3d D = diagonal_[i];
    D.diagonal().array() += shift;
    inverse_diagonal_[i] = Widen(Eigen::Matrix3d(D.inverse()));
  }
}

void StepSystem::ApplyLinked() {
  ParallelFor(rows_, kGrain, [&](int64_t begin, int64_t end) {
    for (int64_t i = begin; i < end; ++i) {
      Vec t = Times(&block_columns_[3 * i], row_in_[i]);
      if (i >= surface_begin_) {
        const int64_t v = i - surface_begin_;
        for (int32_t l = link_begin_[v]; l < link_begin_[v + 1]; ++l) {
          t += Times(&link_columns_[3 * link_edge_[l]], row_in_[link_row_[l]]);
        }
      }
      row_out_[i] = t;
    }
  });
}

void StepSystem::Apply(const Vecs& x, float damping, Vecs* y) {
  // t_i = A_i sum_j S_ij x_j
  ParallelFor(rows_, kGrain, [&](int64_t begin, int64_t end) {
    for (int64_t i = begin; i < end; ++i) {
      Vec u = Vec::Zero();
      for (int32_t s = row_begin_[i]; s < row_begin_[i + 1]; ++s) {
        u += row_weight_[s] * x[row_index_[s]];
      }
      row_in_[i] = u;
      if (!linked_) row_out_[i] = Times(&block_columns_[3 * i], u);
    }
  });
  if (linked_) ApplyLinked();
  // w_i = A_i^-1 sum_j e_ij x (x_i - x_j)
  if (rigid_) {
    ParallelFor(vertices_, kGrain, [&](int64_t begin, int64_t end) {
      for (int64_t i = begin; i < end; ++i) {
        // The lanes of a cross product beyond the third are 0.
        Vec b = edge_sum_[i].cross3(x[i]);
        for (int32_t e = edge_begin_[i]; e < edge_begin_[i + 1]; ++e) {
          b -= edge_[e].cross3(x[edge_neighbor_[e]]);
        }
        turn_[i].noalias() = inverse_inertia_[i] * b;
      }
    });
  }
  // y_j = sum_i S_ij t_i + sum_k ( 2 w_jk (x_j - x_k) - w_j x e_jk + w_k x e_kj ) + damping x_j
  ParallelFor(vertices_, kGrain, [&](int64_t begin, int64_t end) {
    for (int64_t j = begin; j < end; ++j) {
      Vec sum = damping * x[j];
      for (int32_t s = column_begin_[j]; s < column_begin_[j + 1]; ++s) {
        sum += column_weight_[s] * row_out_[column_index_[s]];
      }
      if (rigid_) {
        sum -= turn_[j].cross3(edge_sum_[j]);
        for (int32_t e = edge_begin_[j]; e < edge_begin_[j + 1]; ++e) {
          const int32_t k = edge_neighbor_[e];
          sum += edge_weight_[e] * (x[j] - x[k]);
          sum += turn_[k].cross3(edge_[edge_reverse_[e]]);
        }
      }
      (*y)[j] = sum;
    }
  });
  ApplyAttachments(x, y);
}

void StepSystem::ApplyAttachments(const Vecs& x, Vecs* y) const {
  for (size_t k = 0; k + 1 < attached_begin_.size(); ++k) {
    Vec u = Vec::Zero();
    for (int32_t s = attached_begin_[k]; s < attached_begin_[k + 1]; ++s) {
      u += attached_weight_[s] * x[attached_index_[s]];
    }
    const Vec t = Times(&attached_columns_[3 * k], u);
    for (int32_t s = attached_begin_[k]; s < attached_begin_[k + 1]; ++s) {
      (*y)[attached_index_[s]] += attached_weight_[s] * t;
    }
  }
}

int StepSystem::Solve(const Points3d& half_gradient, double damping, double tolerance,
                      int max_iterations, const CancelFn& cancelled, Points3d* step,
                      double* predicted_decrease) {
  Precondition(damping);
  const float shift = static_cast<float>(damping) * mean_diagonal_;
  for (int64_t i = 0; i < vertices_; ++i) {
    x_[i].setZero();
    r_[i] = Widen((-half_gradient.col(i)).eval());
    z_[i].noalias() = inverse_diagonal_[i] * r_[i];
    p_[i] = z_[i];
  }
  double rz = Dot(r_, z_);
  const double target = tolerance * tolerance * rz;
  int iteration = 0;
  while (iteration < max_iterations && rz > target && rz > 0 && !IsCancelled(cancelled)) {
    ++iteration;
    Apply(p_, shift, &q_);
    const double curvature = Dot(p_, q_);
    if (!(curvature > 0)) break;  // rounding: the system is positive semidefinite
    const float a = static_cast<float>(rz / curvature);
    for (int64_t i = 0; i < vertices_; ++i) {
      x_[i] += a * p_[i];
      r_[i] -= a * q_[i];
      z_[i].noalias() = inverse_diagonal_[i] * r_[i];
    }
    const double rz_next = Dot(r_, z_);
    const float b = static_cast<float>(rz_next / rz);
    rz = rz_next;
    for (int64_t i = 0; i < vertices_; ++i) p_[i] = z_[i] + b * p_[i];
  }
  step->resize(3, vertices_);
  double decrease = 0;
  for (int64_t i = 0; i < vertices_; ++i) {
    step->col(i) = x_[i].head<3>().cast<double>();
    decrease += -half_gradient.col(i).dot(step->col(i)) + shift * step->col(i).squaredNorm();
  }
  *predicted_decrease = decrease;
  return iteration;
}

}  // namespace cagefit
