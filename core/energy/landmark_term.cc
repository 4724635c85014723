#include "core/energy/landmark_term.h"

#include <algorithm>

#include "absl/strings/str_format.h"

namespace cagefit {

namespace {

bool IsSamePlace(const Landmark& a, const Landmark& b) {
  if (a.vertex >= 0 || b.vertex >= 0) return a.vertex == b.vertex;
  return a.at.face == b.at.face && a.at.u == b.at.u && a.at.v == b.at.v;
}

absl::Status Bad(size_t index, const std::string& what) {
  return absl::InvalidArgumentError(absl::StrFormat("landmarks[%d]%s", index, what));
}

}  // namespace

absl::Status CheckLandmarks(const std::vector<Landmark>& landmarks, int64_t vertices,
                            int64_t triangles) {
  for (size_t l = 0; l < landmarks.size(); ++l) {
    const Landmark& landmark = landmarks[l];
    const SurfacePoint& at = landmark.at;
    if (!landmark.position.allFinite()) return Bad(l, ".position is not finite");
    if (landmark.vertex >= vertices) {
      return Bad(
          l, absl::StrFormat(".vertex is %d; the mesh has %d vertices", landmark.vertex, vertices));
    }
    if (landmark.vertex >= 0) continue;
    if (at.face < 0 || at.face >= triangles) {
      return Bad(l,
                 absl::StrFormat(".triangle is %d; the mesh has %d triangles", at.face, triangles));
    }
    if (!(at.u >= 0 && at.v >= 0 && at.u + at.v <= 1)) {
      return Bad(l, absl::StrFormat(".surface is (%g, %g); outside the triangle", at.u, at.v));
    }
  }
  return absl::OkStatus();
}

void LandmarkTerm::SetTarget(absl::Span<const Landmark> landmarks, double weight) {
  if (landmarks.empty() || weight <= 0) {
    attachments_.Clear();
    places_.clear();
    return;
  }
  if (!std::equal(landmarks.begin(), landmarks.end(), places_.begin(), places_.end(),
                  IsSamePlace)) {
    attachments_.rows = Rows(landmarks);
    places_.assign(landmarks.begin(), landmarks.end());
  }
  const auto L = static_cast<int64_t>(landmarks.size());
  const double share = weight * static_cast<double>(topology_.vertex_count()) / L;
  attachments_.weights.assign(L, share * Eigen::Matrix3d::Identity());
  attachments_.targets.resize(3, L);
  for (int64_t l = 0; l < L; ++l) attachments_.targets.col(l) = landmarks[l].position;
}

StencilMatrix LandmarkTerm::Rows(absl::Span<const Landmark> landmarks) {
  std::vector<SurfacePoint> points;
  for (const Landmark& landmark : landmarks) {
    if (landmark.vertex < 0) points.push_back(landmark.at);
  }
  StencilMatrix on_surface;
  if (!points.empty()) {
    if (surface_ == nullptr) surface_ = std::make_unique<LimitSurface>(topology_, tags_);
    on_surface = surface_->Stencils(points, Derivatives::kNone)->position;
  }
  std::vector<Eigen::Triplet<double, int32_t>> entries;
  int32_t row = 0, point = 0;
  for (const Landmark& landmark : landmarks) {
    if (landmark.vertex >= 0) {
      entries.emplace_back(row++, landmark.vertex, 1.0);
      continue;
    }
    for (StencilMatrix::InnerIterator s(on_surface, point); s; ++s) {
      entries.emplace_back(row, s.col(), s.value());
    }
    ++row;
    ++point;
  }
  StencilMatrix rows(row, topology_.vertex_count());
  rows.setFromTriplets(entries.begin(), entries.end());
  return rows;
}

}  // namespace cagefit
