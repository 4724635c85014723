#include "client/report/scene_payload.h"

#include <algorithm>
#include <cmath>

namespace cagefit::client {
namespace {

using Values = std::vector<uint32_t>;

constexpr double kMostCode = 65535;  // of a coordinate, and of a weight
constexpr double kMostDeviation = 127;
// Finer steps below matter more than what is so far beyond the colours.
constexpr double kBeyondRobust = 8;

// Cube that holds points, cut into 65,535 steps a side.
struct Grid {
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();
  double quantum = 1;

  void Append(const Points3d& points, Values* codes) const {
    for (int64_t k = 0; k < points.cols(); ++k) {
      for (int axis = 0; axis < 3; ++axis) {
        const double code = std::round((points(axis, k) - origin[axis]) / quantum);
        codes->push_back(static_cast<uint32_t>(std::clamp(code, 0.0, kMostCode)));
      }
    }
  }
  nlohmann::ordered_json ToJson() const {
    return {{"origin", {origin.x(), origin.y(), origin.z()}}, {"quantum", quantum}};
  }
};

template <typename PointsOf>
Grid GridOf(const Scene& scene, const PointsOf& points_of) {
  Box box;
  for (const SceneFrame& frame : scene.frames) {
    const Box other = BoundingBox(points_of(frame));
    box.min = box.min.cwiseMin(other.min);
    box.max = box.max.cwiseMax(other.max);
  }
  const double side = box.size().maxCoeff();
  if (!(side > 0)) return {};
  return {box.min, side / kMostCode};
}

struct DeviationScale {
  double robust = 0, most = 0;

  uint32_t Code(double deviation) const {
    if (most == 0) return 128;
    const double size = std::sqrt(std::min(1.0, std::abs(deviation) / most));
    return static_cast<uint32_t>(128 + std::copysign(std::round(kMostDeviation * size), deviation));
  }
};

DeviationScale ScaleOf(const Scene& scene) {
  std::vector<double> sizes;
  for (const SceneFrame& frame : scene.frames) {
    for (const double d : frame.surface_deviations) sizes.push_back(std::abs(d));
    for (const double d : frame.point_deviations) sizes.push_back(std::abs(d));
  }
  if (sizes.empty()) return {};
  std::sort(sizes.begin(), sizes.end());
  const double robust = sizes[(sizes.size() - 1) * 99 / 100];
  return {robust, std::min(sizes.back(), kBeyondRobust * robust)};
}

// Each row's rounded weights add up to 65,535: what rounding leaves goes to the largest.
void AddStencils(const StencilMatrix& stencils, Payload* payload) {
  Values sizes, columns, weights;
  for (int32_t row = 0; row < stencils.rows(); ++row) {
    const size_t begin = weights.size();
    auto rest = static_cast<int64_t>(kMostCode);
    for (StencilMatrix::InnerIterator entry(stencils, row); entry; ++entry) {
      const auto weight = static_cast<uint32_t>(std::lround(kMostCode * entry.value()));
      if (weight == 0) continue;
      columns.push_back(static_cast<uint32_t>(entry.col()));
      weights.push_back(weight);
      rest -= weight;
    }
    sizes.push_back(static_cast<uint32_t>(weights.size() - begin));
    uint32_t& largest =
        *std::max_element(weights.begin() + static_cast<int64_t>(begin), weights.end());
    largest = static_cast<uint32_t>(largest + rest);
  }
  payload->Add("row_sizes", 2, 0, sizes);
  payload->Add("columns", 4, 1, columns);
  payload->Add("weights", 2, 0, weights);
}

void AddTriangles(const char* name, const Triangles& triangles, Payload* payload) {
  payload->Add(name, 4, 3, Values(triangles.data(), triangles.data() + triangles.size()));
}

void AddEdges(const char* name, const std::vector<std::array<int32_t, 2>>& edges,
              Payload* payload) {
  Values ends;
  for (const auto& [a, b] : edges) {
    ends.push_back(static_cast<uint32_t>(a));
    ends.push_back(static_cast<uint32_t>(b));
  }
  payload->Add(name, 4, 2, ends);
}

}  // namespace

nlohmann::ordered_json AddScene(const Scene& scene, const ControlMesh& cage, Payload* payload) {
  const DisplayMesh& mesh = scene.mesh;
  const Grid control_grid = GridOf(
      scene, [](const SceneFrame& frame) -> const Points3d& { return *frame.control_vertices; });
  const Grid point_grid =
      GridOf(scene, [](const SceneFrame& frame) -> const Points3d& { return frame.points; });
  const DeviationScale scale = ScaleOf(scene);
  Values control, points, deviations, point_deviations;
  nlohmann::ordered_json frames = nlohmann::ordered_json::array();
  for (const SceneFrame& frame : scene.frames) {
    control_grid.Append(*frame.control_vertices, &control);
    point_grid.Append(frame.points, &points);
    for (const double d : frame.surface_deviations) deviations.push_back(scale.Code(d));
    if (frame.surface_deviations.empty())
      deviations.resize(deviations.size() + mesh.position.rows());
    for (const double d : frame.point_deviations) point_deviations.push_back(scale.Code(d));
    frames.push_back({{"frame", frame.number},
                      {"points", frame.points.cols()},
                      {"target_points", frame.target_points}});
  }
  payload->Add("control", 2, 3 * static_cast<size_t>(cage.vertex_count()), control);
  payload->Add("points", 2, 0, points);
  payload->Add("deviations", 1, 0, deviations);
  payload->Add("point_deviations", 1, 0, point_deviations);
  AddStencils(mesh.position, payload);
  AddTriangles("triangles", mesh.triangles, payload);
  payload->Add("limit_vertices", 4, 1,
               Values(mesh.limit_vertices.begin(), mesh.limit_vertices.end()));
  AddEdges("creases", mesh.creases, payload);
  AddEdges("borders", mesh.borders, payload);
  AddTriangles("cage_triangles", cage.triangles(), payload);
  AddEdges("cage_creases", cage.tags().edges, payload);
  return {{"levels", mesh.levels},
          {"control_vertices", cage.vertex_count()},
          {"control", control_grid.ToJson()},
          {"points", point_grid.ToJson()},
          {"robust_deviation", scale.robust},
          {"most_deviation", scale.most},
          {"frames", std::move(frames)}};
}

}  // namespace cagefit::client
