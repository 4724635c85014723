#include "core/template/surface_cut.h"

#include <algorithm>
#include <map>
#include <utility>
#include <vector>

#include "core/template/mesh_repair.h"

namespace cagefit {

namespace {

constexpr double kCutMargin = 0.1;  // of an edge, at the end inside

class Cutter {
 public:
  Cutter(const TriangleMesh& mesh, const Eigen::ArrayXd& value, double level)
      : mesh_(mesh), value_(value), level_(level) {}

  TriangleMesh Run() {
    for (int64_t f = 0; f < mesh_.triangles.cols(); ++f) {
      const Eigen::Vector3i t = mesh_.triangles.col(f);
      int in = 0, first_in = 0, first_out = 0;
      for (int c = 2; c >= 0; --c) {
        (Inside(t[c]) ? first_in : first_out) = c;
        in += Inside(t[c]);
      }
      if (in == 3) Add(t[0], t[1], t[2]);
      if (in == 1) {
        const int32_t a = t[first_in], b = t[(first_in + 1) % 3], c = t[(first_in + 2) % 3];
        Add(a, Crossing(a, b), Crossing(a, c));
      }
      if (in == 2) {
        const int32_t a = t[first_out], b = t[(first_out + 1) % 3], c = t[(first_out + 2) % 3];
        Add(b, c, Crossing(c, a));
        Add(b, Crossing(c, a), Crossing(b, a));
      }
    }
    TriangleMesh all;
    all.vertices.resize(3, mesh_.vertices.cols() + static_cast<int64_t>(crossings_.size()));
    all.vertices.leftCols(mesh_.vertices.cols()) = mesh_.vertices;
    for (size_t k = 0; k < crossings_.size(); ++k) {
      all.vertices.col(mesh_.vertices.cols() + static_cast<int64_t>(k)) = crossings_[k];
    }
    all.triangles.resize(3, static_cast<int64_t>(triangles_.size()));
    for (size_t k = 0; k < triangles_.size(); ++k) {
      all.triangles.col(static_cast<int64_t>(k)) = triangles_[k];
    }
    return SelectTriangles(all, std::vector<char>(triangles_.size(), 1));
  }

 private:
  bool Inside(int32_t v) const { return value_[v] < level_; }
  void Add(int32_t a, int32_t b, int32_t c) { triangles_.emplace_back(a, b, c); }

  // The vertex at which the line crosses the edge from `in` to `out`.
  int32_t Crossing(int32_t in, int32_t out) {
    const auto [found, is_new] = crossing_of_edge_.try_emplace(
        {in, out}, static_cast<int32_t>(mesh_.vertices.cols() + crossings_.size()));
    if (is_new) {
      // Not so close to an end that its triangles are needles.
      const double t =
          std::clamp((level_ - value_[in]) / (value_[out] - value_[in]), kCutMargin, 1.0);
      crossings_.push_back((1 - t) * mesh_.vertices.col(in) + t * mesh_.vertices.col(out));
    }
    return found->second;
  }

  const TriangleMesh& mesh_;
  const Eigen::ArrayXd& value_;
  const double level_;
  std::vector<Eigen::Vector3i> triangles_;
  std::vector<Eigen::Vector3d> crossings_;
  std::map<std::pair<int32_t, int32_t>, int32_t> crossing_of_edge_;
};

}  // namespace

TriangleMesh CutBelow(const TriangleMesh& mesh, const Eigen::ArrayXd& value, double level) {
  return Cutter(mesh, value, level).Run();
}

}  // namespace cagefit
