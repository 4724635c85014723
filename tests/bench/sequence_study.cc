// The table of the paper: distance, images, and both, over a sequence with known motion.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <string>
#include <vector>

#include "client/io/geometry_file.h"
#include "core/cloud/surface_cloud.h"
#include "core/fit/extrapolation.h"
#include "core/metrics/drift.h"
#include "core/metrics/surface_metrics.h"
#include "core/subdiv/limit.h"
#include "tests/bench/study.h"
#include "tests/support/data.h"

namespace cagefit::bench {
namespace {

struct Sequence {
  std::string name;
  Triangles triangles;          // of the true motion
  std::vector<Points3d> truth;  // per frame
  std::vector<client::Geometry> targets;
};

Sequence Load(const std::string& name, int frames) {
  const std::string folder = testing::DataDir() + "/" + name;
  Sequence out;
  out.name = name;
  client::Geometry first = *client::ReadGeometry(folder + "/template.ply");
  out.triangles = first.mesh.triangles;
  const int64_t n = first.mesh.vertices.cols();
  std::ifstream file(folder + "/vertices.f32", std::ios::binary);
  for (int k = 0; k < frames; ++k) {
    Points3f vertices(3, n);
    file.read(reinterpret_cast<char*>(vertices.data()),
              static_cast<std::streamsize>(sizeof(float) * vertices.size()));
    out.truth.push_back(vertices.cast<double>());
    char path[32];
    std::snprintf(path, sizeof(path), "/drc/frame_%03d.drc", k);
    out.targets.push_back(*client::ReadGeometry(folder + path));
  }
  return out;
}

double Env(const char* name, double other) {
  const char* value = std::getenv(name);
  return value != nullptr ? std::atof(value) : other;
}

struct Row {
  double hausdorff = 0, rms = 0, worst_rms = 0, tangential = 0, mean = 0, early = 0, seconds = 0,
         iterations = 0;
};

Row Run(const Sequence& sequence, const ControlMesh& cage, const FitOptions& options, bool use_mesh,
        int stride) {
  Row row;
  std::optional<Fitter> fitter;
  const LimitMesh limit = BuildLimitMesh(cage.topology(), cage.tags(), kMetricLevels);
  std::optional<DriftMeter> meter;
  Points3d V = cage.vertices(), before;
  double diagonal = 0;
  int count = 0;
  for (size_t k = 0; k < sequence.targets.size(); k += stride) {
    const TriangleMesh truth{sequence.truth[k], sequence.triangles};
    const client::Geometry& geometry = sequence.targets[k];
    // tshirt holds clouds; its true meshes are the mesh targets.
    const bool has_mesh = geometry.mesh.triangles.cols() > 0;
    const TriangleMesh& mesh = has_mesh ? geometry.mesh : truth;
    const PointCloud cloud =
        has_mesh ? SurfaceCloud(geometry.mesh, geometry.normals)
                 : PointCloud{geometry.mesh.vertices.cast<float>(), geometry.normals};
    if (!fitter) {
      const Normalization normalization = *Normalization::FromBox(BoundingBox(cloud.points));
      fitter.emplace(*Fitter::Create(cage, normalization, options));
      diagonal = BoundingBox(cloud.points).diagonal();
    }
    std::vector<Points3d> starts = {V};
    if (before.cols() > 0) starts.push_back(ExtrapolateMotion(before, V, 0.8));
    ImageSource images;
    if (use_mesh) images.mesh = &mesh;
    images.frame = k;
    Points3d fitted;
    const double begin = Seconds();
    const auto summary =
        fitter->Fit(cloud, starts, nullptr, nullptr, &fitted,
                    k == 0 ? StartKind::kTemplate : StartKind::kEarlierFit, images);
    if (!summary.ok()) {
      std::cerr << summary.status() << "\n";
      std::exit(1);
    }
    row.seconds += Seconds() - begin;
    row.iterations += summary->iterations;
    if (std::getenv("VERBOSE"))
      std::printf("  frame %zu: it %d dist %.3g arap %.3g cov %.3g img %.3g\n", k,
                  summary->iterations, summary->final.distance, summary->final.arap,
                  summary->final.coverage, summary->final.image);
    before = k == 0 ? Points3d(3, 0) : V;
    V = fitted;
    TriangleMesh surface;
    ApplyStencils(limit.position, V, &surface.vertices);
    surface.triangles = limit.triangles;
    const SurfaceMetrics metrics = CompareToMesh(surface, truth);
    row.hausdorff +=
        100 * std::max(metrics.target_to_fit.max, metrics.fit_to_target.max) / diagonal;
    row.rms += 100 * metrics.target_to_fit.rms / diagonal;
    row.worst_rms = std::max(row.worst_rms, 100 * metrics.target_to_fit.rms / diagonal);
    if (!meter) meter.emplace(surface, sequence.truth[k]);
    const DriftStats drift = meter->Measure(surface.vertices, sequence.truth[k]);
    row.mean += 100 * drift.mean / diagonal;
    row.tangential += 100 * drift.tangential_mean / diagonal;
    if (count < 10) row.early += 100 * drift.tangential_mean / diagonal / 10;
    ++count;
  }
  for (double* v :
       {&row.hausdorff, &row.rms, &row.mean, &row.tangential, &row.seconds, &row.iterations})
    *v /= count;
  return row;
}

}  // namespace

void StudySequences() {
  for (const std::string name : {"tshirt", "puppet"}) {
    if (const char* only = std::getenv("ONLY"); only != nullptr && name != only) continue;
    const Sequence sequence = Load(name, static_cast<int>(Env("FRAMES", 30)));
    const TriangleMesh first{sequence.truth[0], sequence.triangles};
    const ControlMesh cage = std::getenv("TRUE_TOPOLOGY")
                                 ? *ControlMesh::Create(first.vertices, first.triangles, {})
                                 : CageOf(first, 2046);
    for (const std::string mode : {"distance", "images", "both"}) {
      if (const char* only = std::getenv("MODE"); only != nullptr && mode != only) continue;
      FitOptions options;
      if (std::getenv("PAPER")) { options = FitOptions::Paper(); options.solver.max_iterations = static_cast<int>(Env("ITERATIONS", 300)); if (std::getenv("GN")) { options.solver.solver = Solver::kGaussNewton; } if (std::getenv("RATE")) options.solver.learning_rate = Env("RATE", 1e-3); }
      if (std::getenv("STIFF")) options.solver.first_stiffness = Env("STIFF", 1);
      if (!std::getenv("PAPER")) options.coverage.weight = Env("COVERAGE", 10);
      if (std::getenv("ALPHA")) options.arap.weight = Env("ALPHA", 0);
      if (std::getenv("PREVIOUS")) options.arap.rest = RestMesh::kPreviousFrame;
      options.solver.relative_decrease = Env("DECREASE", 1e-2);
      if (mode != "distance") {
        options.image.views = Views::kSphere;
        options.image.view_count = static_cast<int>(Env("VIEWS", 20));
        options.image.views_per_iteration = static_cast<int>(Env("DRAWN", 0));
        options.image.depth_weight = Env("DEPTH", 0);
        options.image.normal_weight = Env("NORMALS", 0);
        if (std::getenv("BETA")) options.image.weight = Env("BETA", 0);
      }
      if (mode == "images") {
        options.distance.weight = 0;
        options.coverage.weight = 0;
      }
      const Row row =
          Run(sequence, cage, options, Env("MESH", 1) != 0, static_cast<int>(Env("STRIDE", 1)));
      std::printf(
          "%-8s %-9s Hausdorff %.3f RMS %.4f worst %.4f drift %.3f tangential %.3f first ten %.3f; "
          "%.3f s/frame %.1f it\n",
          name.c_str(), mode.c_str(), row.hausdorff, row.rms, row.worst_rms, row.mean,
          row.tangential, row.early, row.seconds, row.iterations);
      std::fflush(stdout);
    }
  }
}

}  // namespace cagefit::bench
