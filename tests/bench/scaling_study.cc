// Time and memory over control vertices and points.
#include <malloc.h>

#include <cstdio>
#include <cstdlib>

#include "core/base/random.h"
#include "core/mesh/area_sampler.h"
#include "tests/bench/study.h"

namespace cagefit::bench {
namespace {

constexpr int32_t kVertices[] = {1000, 2000, 5000, 10'000, 20'000, 50'000};
constexpr int64_t kPoints[] = {10'000, 50'000, 200'000, 500'000, 1'000'000, 2'000'000};
constexpr int32_t kFewVertices = 2000;
constexpr int64_t kSomePoints = 200'000;

// Drawn by area from the surface.
PointCloud Sample(const TriangleMesh& surface, int64_t points) {
  const AreaSampler sampler(surface.vertices, surface.triangles);
  const Points3d normals = VertexNormals(surface);
  Random random(1);
  PointCloud cloud;
  cloud.points.resize(3, points);
  cloud.normals.resize(3, points);
  for (int64_t i = 0; i < points; ++i) {
    const AreaSampler::Point at = sampler.Draw(&random);
    Eigen::Vector3d x = Eigen::Vector3d::Zero(), n = x;
    for (int c = 0; c < 3; ++c) {
      const int32_t v = surface.triangles(c, at.triangle);
      x += at.weights[c] * surface.vertices.col(v);
      n += at.weights[c] * normals.col(v);
    }
    cloud.points.col(i) = x.cast<float>();
    cloud.normals.col(i) = n.normalized().cast<float>();
  }
  return cloud;
}

double AllocatedMegabytes() {
  const struct mallinfo2 info = mallinfo2();
  return static_cast<double>(info.uordblks + info.hblkhd) / (1 << 20);
}

void Row(const ControlMesh& cage, const PointCloud& cloud) {
  const auto normalization = Normalization::FromBox(BoundingBox(cloud.points));
  const double before = AllocatedMegabytes(), begin = Seconds();
  auto fitter = Fitter::Create(cage, *normalization, FitOptions());
  const double created = Seconds();
  Points3d fitted;
  const auto summary = fitter->Fit(
      cloud, {cage.vertices()}, nullptr, [] { return 1000 * Seconds(); }, &fitted);
  if (!summary.ok()) std::abort();
  std::printf("| %d | %ld | %.0f ms | %.0f ms | %.0f ms | %d | %.1f ms | %.0f MB |\n",
              cage.vertex_count(), static_cast<long>(cloud.size()), 1000 * (created - begin),
              summary->index_ms, summary->solve_ms, summary->iterations,
              summary->solve_ms / summary->iterations, AllocatedMegabytes() - before);
  std::fflush(stdout);
}

}  // namespace

void StudyScaling() {
  std::printf(
      "| control vertices | points | once a session | cleaning and index | fit | steps | a step | "
      "memory of the fitter |\n"
      "| ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: |\n");
  const TriangleMesh surface = BumpySphere(7);
  const PointCloud cloud = Sample(surface, kSomePoints);
  for (const int32_t vertices : kVertices) Row(CageOf(surface, vertices), cloud);
  const ControlMesh cage = CageOf(surface, kFewVertices);
  for (const int64_t points : kPoints) Row(cage, Sample(surface, points));
}

}  // namespace cagefit::bench
