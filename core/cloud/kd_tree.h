// Nearest neighbours in a cloud. The only place that knows nanoflann.
#ifndef CAGEFIT_CORE_CLOUD_KD_TREE_H_
#define CAGEFIT_CORE_CLOUD_KD_TREE_H_

#include <cstdint>
#include <memory>

#include "core/base/types.h"

namespace cagefit {

// Refers to `points` (3 x N floats), which must outlive it. Queries are thread-safe.
class KdTree {
 public:
  explicit KdTree(const Points3f& points);
  ~KdTree();
  KdTree(KdTree&&) noexcept;
  KdTree& operator=(KdTree&&) noexcept;

  // The k nearest points to x, nearest first. Writes at most k indices
  // and squared distances and returns how many there were.
  int Nearest(const Eigen::Vector3f& x, int k, int32_t* indices, float* squared_distances) const;

 private:
  struct Index;
  std::unique_ptr<Index> index_;
};

}  // namespace cagefit

#endif  // CAGEFIT_CORE_CLOUD_KD_TREE_H_
