#include "core/subdiv/foot_search.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>

namespace cagefit {

namespace {

constexpr int kMaxSteps = 60;
constexpr int kMaxHalvings = 20;
constexpr double kOnEdge = 1e-12;  // weight of the opposite corner
constexpr double kRounding = 4e-15;

std::array<double, 3> CornerWeights(const SurfacePoint& at) {
  return {1 - at.u - at.v, at.u, at.v};
}

bool IsOnEdge(const SurfacePoint& at, int c) { return CornerWeights(at)[(c + 2) % 3] <= kOnEdge; }

// The corner that the point is, or -1.
int CornerOf(const SurfacePoint& at) {
  for (int c = 0; c < 3; ++c) {
    if (IsOnEdge(at, c) && IsOnEdge(at, (c + 2) % 3)) return c;
  }
  return -1;
}

// The point with weights a, b of the corners after corner c.
SurfacePoint FromCorner(int32_t face, int c, double a, double b) {
  std::array<double, 3> weights = {};
  weights[c] = 1 - a - b;
  weights[(c + 1) % 3] = a;
  weights[(c + 2) % 3] = b;
  return {face, weights[1], weights[2]};
}

// Calls visit(point) for the same point as seen from each other triangle that holds it, until that
// returns true; returns whether it did.
template <typename Visit>
bool VisitOthers(const LimitSurface& surface, const SurfacePoint& at, const Visit& visit) {
  const int corner = CornerOf(at);
  if (corner < 0) {
    for (int c = 0; c < 3; ++c) {
      if (!IsOnEdge(at, c)) continue;
      const SurfacePoint other = surface.Across(at, c);
      if (other.face >= 0 && visit(other)) return true;
    }
    return false;
  }
  for (const int side : {0, 2}) {  // across the edge that leaves the corner, then the other
    SurfacePoint other = FromCorner(at.face, corner, 0, 0);
    for (;;) {
      other = surface.Across(other, (CornerOf(other) + side) % 3);
      if (other.face == at.face) return false;
      if (other.face < 0) break;
      if (visit(other)) return true;
    }
  }
  return false;
}

// H with the absolute values of its eigenvalues in the surface's metric, and none below 0.01: f's
// slopes are kept, its saddles left.
Eigen::Matrix2d MadeConvex(const Eigen::Matrix2d& H, const Eigen::Matrix2d& metric) {
  constexpr double kLeast = 0.01;
  const Eigen::Matrix2d M = metric + 1e-12 * metric.trace() * Eigen::Matrix2d::Identity();
  const Eigen::Matrix2d L = M.llt().matrixL();
  const Eigen::Matrix2d inverse = L.inverse();
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> eigen;
  eigen.computeDirect(inverse * H * inverse.transpose());
  const Eigen::Vector2d values = eigen.eigenvalues().cwiseAbs().cwiseMax(kLeast);
  const Eigen::Matrix2d axes = L * eigen.eigenvectors();
  return axes * values.asDiagonal() * axes.transpose();
}

}  // namespace

FootSearch::FootSearch(const LimitSurface& surface, const Points3d& control_points,
                       const Eigen::Vector3d& x, double tolerance)
    : surface_(surface), control_points_(control_points), x_(x), tolerance_(tolerance) {}

double FootSearch::LongestEdge(int32_t face) const {
  const auto corners = surface_.topology().triangles().col(face);
  const Eigen::Vector3d a = control_points_.col(corners(0)), b = control_points_.col(corners(1)),
                        c = control_points_.col(corners(2));
  return std::sqrt(std::max({(b - a).squaredNorm(), (c - b).squaredNorm(), (a - c).squaredNorm()}));
}

FootSearch::State FootSearch::Evaluate(const SurfacePoint& at, Derivatives derivatives) const {
  State state;
  state.at = at;
  state.at_pole = surface_.IsExtraordinary(at);
  state.jet =
      surface_.Evaluate(control_points_, at, state.at_pole ? Derivatives::kFirst : derivatives);
  state.f = 0.5 * (state.jet.position - x_).squaredNorm();
  return state;
}

double FootSearch::Value(const SurfacePoint& at) const {
  return 0.5 *
         (surface_.Evaluate(control_points_, at, Derivatives::kNone).position - x_).squaredNorm();
}

FootSearch::Step FootSearch::FindStep(const State& state) const {
  const SurfaceJet& jet = state.jet;
  const Eigen::Vector3d r = jet.position - x_;
  const Eigen::Vector2d g(r.dot(jet.du), r.dot(jet.dv));
  Eigen::Matrix2d metric, H;
  metric << jet.du.squaredNorm(), jet.du.dot(jet.dv), 0, jet.dv.squaredNorm();
  metric(1, 0) = metric(0, 1);
  H << r.dot(jet.duu), r.dot(jet.duv), r.dot(jet.duv), r.dot(jet.dvv);
  H += metric;
  Step step;
  constexpr double kFlattest = 1e-6;
  step.is_newton = H(0, 0) > kFlattest * metric(0, 0) && H(1, 1) > kFlattest * metric(1, 1) &&
                   H.determinant() > kFlattest * H(0, 0) * H(1, 1);
  if (!step.is_newton) H = MadeConvex(H, metric);
  const Eigen::Vector2d p(state.at.u, state.at.v);
  static_cast<TriangleStep&>(step) = MinimizeInTriangle(p, g, H);
  const Eigen::Vector2d d = step.target - p;
  step.length = (d.x() * jet.du + d.y() * jet.dv).norm() / LongestEdge(state.at.face);
  return step;
}

// Goes the way of `step`, or the part of it that lowers f; false if none does.
bool FootSearch::Take(const Step& step, State* state) const {
  const SurfacePoint target = {state->at.face, step.target.x(), step.target.y()};
  SurfacePoint landed = target;
  if (step.edge >= 0) {
    const SurfacePoint other = surface_.Across(target, step.edge);
    if (other.face >= 0) landed = other;
  }
  double part = 1;
  for (int k = 0; k < kMaxHalvings; ++k) {
    const State next = Evaluate(landed, Derivatives::kSecond);
    if (next.f <= state->f * (1 + kRounding)) {
      *state = next;
      return true;
    }
    part /= 2;
    landed = {target.face, state->at.u + part * (target.u - state->at.u),
              state->at.v + part * (target.v - state->at.v)};
  }
  return false;
}

// Goes on in another triangle that holds the point, if one offers a step.
bool FootSearch::LeaveTriangle(State* state) const {
  return VisitOthers(surface_, state->at, [&](const SurfacePoint& at) {
    State other = Evaluate(at, Derivatives::kSecond);
    const Step step = FindStep(other);
    if (!(step.length > tolerance_) || !Take(step, &other)) return false;
    *state = other;
    return true;
  });
}

// From an extraordinary vertex goes where f falls most among three directions in each triangle. How
// far, follows from the tangential part t of x - S over the edge: with the valence, distances grow
// as powers 0.67 (of high ones) to 2 (of 3) of u and v. It is less far where the surface bends more
// than x is near.
bool FootSearch::LeavePole(State* state) const {
  constexpr int kReaches = 8;
  const Eigen::Vector3d normal = state->jet.du.cross(state->jet.dv).normalized();
  const Eigen::Vector3d r = x_ - state->jet.position;
  const double tangential = (r - normal * normal.dot(r)).norm() / LongestEdge(state->at.face);
  if (!(tangential > tolerance_)) return false;
  const double farthest = std::min(0.5 * std::sqrt(tangential), 0.25);
  const double nearest = std::max(1e-3 * std::pow(std::min(tangential, 1.0), 1.5), 1e-13);
  const double factor = std::pow(nearest / farthest, 1.0 / (kReaches - 1));
  double reach = farthest;
  for (int k = 0; k < kReaches; ++k, reach *= factor) {
    double least = state->f;
    SurfacePoint best;
    const auto probe = [&](const SurfacePoint& at) {
      for (const double a : {0.0, 0.5, 1.0}) {
        const SurfacePoint point = FromCorner(at.face, CornerOf(at), reach * a, reach * (1 - a));
        const double f = Value(point);
        if (f >= least) continue;
        least = f;
        best = point;
      }
      return false;
    };
    probe(state->at);
    VisitOthers(surface_, state->at, probe);
    if (best.face < 0) continue;
    *state = Evaluate(best, Derivatives::kSecond);
    return true;
  }
  return false;
}

SurfaceFoot FootSearch::Foot(const State& state) const {
  SurfaceFoot foot;
  foot.at = state.at;
  foot.position = state.jet.position;
  foot.normal = state.jet.du.cross(state.jet.dv).normalized();
  const Eigen::Vector3d offset = x_ - state.jet.position;
  foot.distance = offset.norm();
  const Eigen::Vector3d tangential = offset - foot.normal * foot.normal.dot(offset);
  foot.is_free = tangential.norm() <= 2 * tolerance_ * LongestEdge(state.at.face);
  for (int c = 0; c < 3; ++c) {
    const bool is_boundary = surface_.topology().opposite(3 * state.at.face + c) == Topology::kNone;
    foot.on_boundary = foot.on_boundary || (is_boundary && IsOnEdge(state.at, c));
  }
  return foot;
}

SurfaceFoot FootSearch::Run(const SurfacePoint& start) const {
  State state = Evaluate(start, Derivatives::kSecond);
  double last = 0;  // length of the step before if it was free, else 0
  for (int k = 0; k < kMaxSteps; ++k) {
    if (state.at_pole) {
      if (!LeavePole(&state)) break;
      last = 0;
      continue;
    }
    const Step step = FindStep(state);
    if (!(step.length > tolerance_)) {
      if (!LeaveTriangle(&state)) break;
      last = 0;
      continue;
    }
    // Newton's steps are as the squares of those before, by a factor that the last two tell.
    const bool is_free = step.edge < 0 && step.is_newton;
    const double squared = step.length * step.length;
    if (is_free && last > 0 &&
        squared * std::max(1.0, 10 * step.length / (last * last)) < tolerance_) {
      state = Evaluate({state.at.face, step.target.x(), step.target.y()}, Derivatives::kFirst);
      break;
    }
    if (!Take(step, &state) && !LeaveTriangle(&state)) break;
    last = is_free ? step.length : 0;
  }
  return Foot(state);
}

}  // namespace cagefit
