#include "core/cloud/cell_grid.h"

#include <algorithm>
#include <limits>

namespace cagefit {

namespace {

// Squared length below which a normal has no direction.
constexpr float kMinSquaredNormal = 1e-12f;

}  // namespace

int32_t CellGrid::FindOrInsert(uint64_t key) {
  for (uint64_t s = Hash(key);; s = (s + 1) & slot_mask_) {
    if (slots_[s].key == key) return slots_[s].cell;
    if (slots_[s].key == kEmpty) {
      slots_[s].key = key;
      slots_[s].cell = static_cast<int32_t>(cell_begin_.size());
      cell_begin_.push_back(0);
      return slots_[s].cell;
    }
  }
}

void CellGrid::Build(const PointCloud& cloud, double cell) {
  const int64_t count = cloud.size();
  const bool oriented = cloud.has_normals();
  const Box box = BoundingBox(cloud.points);
  // A grid finer than a millionth of the box would not pack into keys; such a cell is useless
  // anyhow.
  cell_ = std::max(cell, box.size().maxCoeff() / (kMaxCellsPerAxis - 2));
  if (cell_ <= 0) cell_ = 1;
  inverse_cell_ = 1 / cell_;
  origin_ = box.empty() ? Eigen::Array3d(0, 0, 0) : Eigen::Array3d(box.min.array());
  last_cell_ = (box.size().array() * inverse_cell_).floor();

  // At most half full, so that a probe for an absent cell stops soon.
  int bits = 4;
  while ((int64_t{1} << bits) < 2 * count) ++bits;
  slot_mask_ = (uint64_t{1} << bits) - 1;
  hash_shift_ = 64 - bits;
  slots_.assign(slot_mask_ + 1, Slot{});
  cell_begin_.clear();
  cell_of_point_.resize(count);

  int64_t kept = 0;
  for (int64_t i = 0; i < count; ++i) {
    if (oriented && !(cloud.normals.col(i).squaredNorm() > kMinSquaredNormal)) {
      cell_of_point_[i] = -1;
      continue;
    }
    const Eigen::Array3i c =
        ((cloud.points.col(i).cast<double>().array() - origin_) * inverse_cell_).cast<int>();
    const int32_t index = FindOrInsert(Key(c.x(), c.y(), c.z()));
    cell_of_point_[i] = index;
    ++cell_begin_[index];
    ++kept;
  }

  int32_t begin = 0;
  for (int32_t& b : cell_begin_) {
    const int32_t in_cell = b;
    b = begin;
    begin += in_cell;
  }
  size_ = kept;
  stride_ = kept + kPadding;
  coordinates_.assign(6 * stride_, 0.0f);
  source_.resize(kept);
  float* const out = coordinates_.data();
  for (int64_t i = 0; i < count; ++i) {
    if (cell_of_point_[i] < 0) continue;
    const int32_t at = cell_begin_[cell_of_point_[i]]++;
    source_[at] = static_cast<int32_t>(i);
    const Eigen::Vector3f normal =
        oriented ? cloud.normals.col(i).normalized() : Eigen::Vector3f::Zero();
    for (int axis = 0; axis < 3; ++axis) {
      out[axis * stride_ + at] = cloud.points(axis, i);
      out[(3 + axis) * stride_ + at] = normal[axis];
    }
  }
  // Scattering moved every begin to its end; shift back.
  cell_begin_.insert(cell_begin_.begin(), 0);
}

double CellGrid::KthDistance(const Eigen::Vector3d& x, int k, std::vector<float>* scratch) const {
  if (size() < k) return std::numeric_limits<double>::infinity();
  const Eigen::Vector3f xf = x.cast<float>();
  for (double radius = cell_ / 2;; radius *= 2) {
    const float squared_radius = static_cast<float>(radius * radius);
    scratch->clear();
    ForEachRun(x, radius, [&](int32_t begin, int32_t end) {
      for (int32_t i = begin; i < end; ++i) {
        const float squared =
            (Eigen::Vector3f(point(0)[i], point(1)[i], point(2)[i]) - xf).squaredNorm();
        if (squared <= squared_radius) scratch->push_back(squared);
      }
    });
    if (static_cast<int>(scratch->size()) < k) continue;
    std::nth_element(scratch->begin(), scratch->begin() + (k - 1), scratch->end());
    return std::sqrt(static_cast<double>((*scratch)[k - 1]));
  }
}

}  // namespace cagefit
