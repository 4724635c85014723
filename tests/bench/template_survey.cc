// Makes templates from the files named and prints what they are like, a row each: how good the
// triangles are, how long it took, and whether the contract of template_maker.h holds.
//
//   template_survey 500,2000 FILE...
#include <Eigen/Geometry>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include "absl/strings/numbers.h"
#include "absl/strings/str_split.h"
#include "client/io/geometry_file.h"
#include "core/base/status.h"
#include "core/cloud/normals.h"
#include "core/mesh/triangle_quality.h"
#include "core/template/template_maker.h"

namespace cagefit {
namespace {

struct Triangle {
  double quality;
  double angle;  // the smallest, degrees
};

Triangle Measure(const Eigen::Matrix3d& p) {
  const Eigen::Vector3d sides[3] = {p.col(1) - p.col(0), p.col(2) - p.col(1), p.col(0) - p.col(2)};
  double angle = M_PI;
  for (int k = 0; k < 3; ++k) {
    const Eigen::Vector3d u = sides[k], w = -sides[(k + 2) % 3];
    angle = std::min(angle, std::atan2(u.cross(w).norm(), u.dot(w)));
  }
  return {TriangleQuality(p.col(0), p.col(1), p.col(2)), angle * 180 / M_PI};
}

absl::StatusOr<ControlMesh> Make(const client::Geometry& geometry, int32_t vertices,
                                 TemplateReport* report) {
  if (!geometry.is_cloud()) return TemplateFromMesh(geometry.mesh, {vertices, {}}, report);
  PointCloud cloud = ToCloud(geometry);
  if (!cloud.has_normals()) RETURN_IF_ERROR(EstimateNormals({}, &cloud));
  return TemplateFromCloud(cloud, {vertices, {}}, report);
}

// Whether the contract holds.
bool PrintRow(const std::string& file, const client::Geometry& geometry, int32_t vertices) {
  TemplateReport report;
  const auto start = std::chrono::steady_clock::now();
  const auto cage = Make(geometry, vertices, &report);
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
  std::printf("%-32s %6d ", file.substr(file.rfind('/') + 1).c_str(), vertices);
  if (!cage.ok()) {
    std::printf("%s\n", cage.status().ToString().c_str());
    return false;
  }
  const Topology& topology = cage->topology();
  int good = 0, low = 0, needles = 0;
  for (int32_t v = 0; v < cage->vertex_count(); ++v) {
    const int valence = topology.Valence(v);
    const bool boundary = topology.IsBoundaryVertex(v);
    good += boundary ? valence >= 3 && valence <= 5 : valence >= 5 && valence <= 7;
    low += valence < (boundary ? 2 : 3);
  }
  double quality = 1, angle = 180;
  for (int32_t f = 0; f < topology.triangle_count(); ++f) {
    Eigen::Matrix3d p;
    for (int c = 0; c < 3; ++c) p.col(c) = cage->vertices().col(topology.triangles()(c, f));
    const Triangle triangle = Measure(p);
    quality = std::min(quality, triangle.quality);
    angle = std::min(angle, triangle.angle);
    needles += triangle.quality < 0.1;
  }
  const bool holds =
      low == 0 && std::abs(cage->vertex_count() - vertices) <= std::max(0.01 * vertices, 0.0);
  std::printf("%6d %5.1f %6.3f %5.1f %4d %3d/%-3d %3d %5d %6.2f s%s\n", cage->vertex_count(),
              100.0 * good / cage->vertex_count(), quality, angle, needles, report.components_kept,
              report.components_dropped, report.boundary_loops, report.crease_edges,
              seconds.count(), holds ? "" : "  BROKEN");
  std::fflush(stdout);
  return holds;
}

int Survey(int count, char** arguments) {
  if (count < 3) {
    std::fprintf(stderr, "usage: template_survey COUNT[,COUNT...] FILE...\n");
    return 2;
  }
  std::printf(
      "%-32s %6s %6s %5s %6s %5s %4s %7s %3s %5s\n"
      "%-32s %6s %6s %5s %6s %5s %4s %7s %3s %5s\n",
      "file", "asked", "got", "5-7%", "least", "least", "<0.1", "parts", "bo.", "crea-",  //
      "", "", "", "", "qual.", "angle", "", "kept/not", "lo.", "ses");
  bool all = true;
  for (int k = 2; k < count; ++k) {
    const auto geometry = client::ReadGeometry(arguments[k]);
    if (!geometry.ok()) {
      std::printf("%s\n", geometry.status().ToString().c_str());
      return 1;
    }
    for (const absl::string_view word : absl::StrSplit(arguments[1], ',')) {
      int32_t vertices = 0;
      if (!absl::SimpleAtoi(word, &vertices)) return 2;
      all = PrintRow(arguments[k], *geometry, vertices) && all;
    }
  }
  return all ? 0 : 1;
}

}  // namespace
}  // namespace cagefit

int main(int count, char** arguments) { return cagefit::Survey(count, arguments); }
