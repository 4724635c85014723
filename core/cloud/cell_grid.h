// Points sorted into the occupied cells of a uniform grid: runs of neighbours for fixed-radius
// sums.
//
// Building is two passes over the points. A ball whose diameter does not exceed the cell touches at
// most 8 cells, so with cell = 2 h a sum over the ball of radius h reads a handful of contiguous
// runs.
#ifndef CAGEFIT_CORE_CLOUD_CELL_GRID_H_
#define CAGEFIT_CORE_CLOUD_CELL_GRID_H_

#include <cmath>
#include <cstdint>
#include <vector>

#include "core/cloud/point_cloud.h"

namespace cagefit {

// Copies the points. Queries are thread-safe and do not allocate. The order of runs and of the
// points in them depends on the cloud alone.
class CellGrid {
 public:
  // Sorts `cloud` into cells of the given size > 0. Points whose normal has no direction are left
  // out; of a cloud without normals none is, and normal() is 0. Buffers keep their capacity.
  void Build(const PointCloud& cloud, double cell);

  // Calls visit(begin, end) for each run of sorted points that may hold points within `radius` of
  // x.
  template <typename Visit>
  void ForEachRun(const Eigen::Vector3d& x, double radius, const Visit& visit) const {
    const Eigen::Array3d low = ((x.array() - radius - origin_) * inverse_cell_).floor();
    const Eigen::Array3d high = ((x.array() + radius - origin_) * inverse_cell_).floor();
    const Eigen::Array3i first = low.max(0.0).min(last_cell_ + 1.0).cast<int>();
    const Eigen::Array3i last = high.max(-1.0).min(last_cell_).cast<int>();
    const Eigen::Array3d cells = (last - first + 1).max(0).cast<double>();
    if (cells.prod() > static_cast<double>(cell_begin_.size())) {
      visit(0, static_cast<int32_t>(size()));
      return;
    }
    for (int z = first.z(); z <= last.z(); ++z) {
      for (int y = first.y(); y <= last.y(); ++y) {
        for (int x_cell = first.x(); x_cell <= last.x(); ++x_cell) {
          const int32_t c = Find(Key(x_cell, y, z));
          if (c >= 0) visit(cell_begin_[c], cell_begin_[c + 1]);
        }
      }
    }
  }

  // Distance from x to the k-th nearest point (k >= 1; x itself counts where it is a point).
  // Infinite when the grid holds fewer than k points. `scratch` keeps its capacity from call to
  // call.
  double KthDistance(const Eigen::Vector3d& x, int k, std::vector<float>* scratch) const;

  int64_t size() const { return size_; }
  double cell() const { return cell_; }
  // Diagonal of the cloud's bounding box, rounded up to whole cells.
  double diagonal() const { return (last_cell_ + 1).matrix().norm() * cell_; }

  // Index in the cloud of sorted point i.
  int32_t source(int64_t i) const { return source_[i]; }
  Eigen::Vector3f point_at(int64_t i) const { return {point(0)[i], point(1)[i], point(2)[i]}; }
  Eigen::Vector3f normal_at(int64_t i) const { return {normal(0)[i], normal(1)[i], normal(2)[i]}; }

  // Occupied cells; the sorted points of cell c are cell_begin(c) to cell_begin(c + 1).
  int64_t cells() const { return static_cast<int64_t>(cell_begin_.size()) - 1; }
  int32_t cell_begin(int64_t c) const { return cell_begin_[c]; }

  // Coordinate `axis` of the sorted points. Readable up to kPadding entries behind the last.
  const float* point(int axis) const { return coordinates_.data() + axis * stride_; }
  // Component `axis` of their unit normals, likewise.
  const float* normal(int axis) const { return coordinates_.data() + (3 + axis) * stride_; }
  static constexpr int64_t kPadding = 16;

 private:
  static constexpr int kMaxCellsPerAxis = 1 << 20;

  struct Slot {
    uint64_t key = kEmpty;
    int32_t cell = -1;
  };
  static constexpr uint64_t kEmpty = ~uint64_t{0};

  static uint64_t Key(int x, int y, int z) {
    return static_cast<uint64_t>(x) | static_cast<uint64_t>(y) << 21 |
           static_cast<uint64_t>(z) << 42;
  }
  uint64_t Hash(uint64_t key) const { return (key * 0x9E3779B97F4A7C15u) >> hash_shift_; }
  int32_t Find(uint64_t key) const {
    for (uint64_t s = Hash(key);; s = (s + 1) & slot_mask_) {
      if (slots_[s].key == key) return slots_[s].cell;
      if (slots_[s].key == kEmpty) return -1;
    }
  }
  int32_t FindOrInsert(uint64_t key);

  double cell_ = 0, inverse_cell_ = 0;
  Eigen::Array3d origin_ = Eigen::Array3d::Zero();
  Eigen::Array3d last_cell_ = Eigen::Array3d::Zero();
  std::vector<Slot> slots_;
  uint64_t slot_mask_ = 0;
  int hash_shift_ = 0;
  std::vector<int32_t> cell_begin_;     // cells + 1
  std::vector<int32_t> cell_of_point_;  // input order; -1: left out
  std::vector<int32_t> source_;
  int64_t size_ = 0, stride_ = 0;
  std::vector<float> coordinates_;  // x, y, z, nx, ny, nz, each of stride_ entries
};

}  // namespace cagefit

#endif  // CAGEFIT_CORE_CLOUD_CELL_GRID_H_
