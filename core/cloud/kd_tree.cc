#include "core/cloud/kd_tree.h"

#include <algorithm>
#include <nanoflann.hpp>

namespace cagefit {

namespace {

constexpr size_t kLeafSize = 16;

struct Columns {
  const Points3f* points;
  size_t kdtree_get_point_count() const { return static_cast<size_t>(points->cols()); }
  float kdtree_get_pt(size_t i, size_t axis) const {
    return (*points)(static_cast<Eigen::Index>(axis), static_cast<Eigen::Index>(i));
  }
  template <class BoundingBox>
  bool kdtree_get_bbox(BoundingBox&) const {
    return false;  // nanoflann computes it
  }
};

using Tree = nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<float, Columns>,
                                                 Columns, 3, int32_t>;

}  // namespace

struct KdTree::Index {
  explicit Index(const Points3f& points)
      : columns{&points}, tree(3, columns, nanoflann::KDTreeSingleIndexAdaptorParams(kLeafSize)) {}
  Columns columns;
  Tree tree;
};

KdTree::KdTree(const Points3f& points) : index_(std::make_unique<Index>(points)) {}
KdTree::~KdTree() = default;
KdTree::KdTree(KdTree&&) noexcept = default;
KdTree& KdTree::operator=(KdTree&&) noexcept = default;

int KdTree::Nearest(const Eigen::Vector3f& x, int k, int32_t* indices,
                    float* squared_distances) const {
  if (index_->columns.points->cols() == 0) return 0;
  nanoflann::KNNResultSet<float, int32_t> result(k);
  result.init(indices, squared_distances);
  index_->tree.findNeighbors(result, x.data(), nanoflann::SearchParams());
  return static_cast<int>(result.size());
}

}  // namespace cagefit
