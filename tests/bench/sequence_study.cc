// The table of the paper: distance, images, and both, over sequences with known motion.
#include <algorithm>
#include <cstdio>
#include <fstream>
#include <iostream>
#include <optional>
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

constexpr int kFrames = 30;
constexpr int32_t kControlVertices = 2046;
constexpr double kMomentum = 0.8;  // as a session has it

struct Frame {
  TriangleMesh truth;
  TriangleMesh mesh;  // what images are rendered from
  PointCloud cloud;
};

// Frames of the test data, by the sequence's name there. Where they are clouds their meshes are the
// true ones.
std::vector<Frame> LoadSequence(const std::string& name) {
  const std::string folder = testing::DataDir() + "/" + name;
  const Triangles triangles = LoadModel(name + "/template.ply").mesh.triangles;
  const int64_t n = triangles.maxCoeff() + 1;
  std::ifstream file(folder + "/vertices.f32", std::ios::binary);
  std::vector<Frame> frames;
  for (int k = 0; k < kFrames; ++k) {
    Points3f vertices(3, n);
    file.read(reinterpret_cast<char*>(vertices.data()),
              static_cast<std::streamsize>(sizeof(float) * vertices.size()));
    char path[32];
    std::snprintf(path, sizeof(path), "/drc/frame_%03d.drc", k);
    const auto geometry = client::ReadGeometry(folder + path);
    if (!file || !geometry.ok()) {
      std::cerr << folder << path << ": " << geometry.status() << "\n";
      std::exit(EXIT_FAILURE);
    }
    Frame frame;
    frame.truth = {vertices.cast<double>(), triangles};
    const bool is_mesh = !geometry->is_cloud();
    frame.mesh = is_mesh ? geometry->mesh : frame.truth;
    frame.cloud = is_mesh ? SurfaceCloud(geometry->mesh, geometry->normals)
                          : PointCloud{geometry->mesh.vertices.cast<float>(), geometry->normals};
    frames.push_back(std::move(frame));
  }
  return frames;
}

// What images and boundaries are of.
enum class KnownBy { kMesh, kPoints };

struct Setting {
  const char* name;
  double distance_weight, coverage_weight, boundary_weight;
  Views views;
};
constexpr Setting kDistance = {"distance", 1, 0, 0, Views::kNone};
constexpr Setting kImages = {"images", 0, 0, 0, Views::kSphere};
constexpr Setting kBoth = {"distance, images", 1, 0, 0, Views::kSphere};
constexpr Setting kBoundary = {"distance, boundary", 1, 0, 0.1, Views::kNone};
constexpr Setting kBoundaryToo = {"distance, boundary, images", 1, 0, 0.1, Views::kSphere};
constexpr Setting kDefault = {"default: distance, boundary, coverage", 1, 10, 0.1, Views::kNone};
constexpr Setting kAll = {"default and images", 1, 10, 0.1, Views::kSphere};

struct Tracking {
  double hausdorff = 0, worst_rms = 0;          // mean and largest over the frames, percent
  double drift = 0, tangential = 0, early = 0;  // means; of the first ten frames, tangential
  double shared = 0;                            // drift at every third frame
};

Tracking Track(const std::vector<Frame>& frames, const ControlMesh& cage, const FitOptions& options,
               KnownBy known_by, int stride) {
  const LimitMesh limit = BuildLimitMesh(cage.topology(), cage.tags(), kMetricLevels);
  const double diagonal = BoundingBox(frames[0].cloud.points).diagonal();
  const auto normalization = Normalization::FromBox(BoundingBox(frames[0].cloud.points));
  auto fitter = Fitter::Create(cage, *normalization, options);
  std::optional<DriftMeter> meter;
  Points3d V = cage.vertices(), before(3, 0);
  Tracking out;
  int count = 0, shared = 0;
  for (int k = 0; k < kFrames; k += stride, ++count) {
    const Frame& frame = frames[k];
    std::vector<Points3d> starts = {V};
    if (before.cols() > 0) starts.push_back(ExtrapolateMotion(before, V, kMomentum));
    FrameSource images;
    if (known_by == KnownBy::kMesh) images.mesh = &frame.mesh;
    Points3d fitted;
    const auto summary =
        fitter->Fit(frame.cloud, starts, nullptr, nullptr, &fitted,
                    k == 0 ? StartKind::kTemplate : StartKind::kEarlierFit, images);
    if (!summary.ok()) {
      std::cerr << "frame " << k << ": " << summary.status() << "\n";
      std::exit(EXIT_FAILURE);
    }
    if (k > 0) before = V;
    V = fitted;
    TriangleMesh surface;
    ApplyStencils(limit.position, V, &surface.vertices);
    surface.triangles = limit.triangles;
    const SurfaceMetrics metrics = CompareToMesh(surface, frame.truth);
    out.hausdorff += metrics.Percent(metrics.hausdorff());
    out.worst_rms = std::max(out.worst_rms, metrics.Percent(metrics.target_to_fit.rms));
    if (!meter.has_value()) meter.emplace(surface, frame.truth.vertices);
    const DriftStats drift = meter->Measure(surface.vertices, frame.truth.vertices);
    const double percent = 100 / diagonal;
    out.drift += percent * drift.mean;
    out.tangential += percent * drift.tangential_mean;
    if (k < 10) out.early += percent * drift.tangential_mean * stride / 10;
    if (k % 3 == 0) {
      out.shared += percent * drift.mean;
      ++shared;
    }
  }
  for (double* sum : {&out.hausdorff, &out.drift, &out.tangential}) *sum /= count;
  out.shared /= shared;
  return out;
}

void Print(const std::string& sequence, const char* what, const Setting& setting,
           const Tracking& t) {
  std::printf("| %s | %s | %s | %.3f | %.4f | %.3f | %.3f | %.3f | %.3f |\n", sequence.c_str(),
              what, setting.name, t.hausdorff, t.worst_rms, t.drift, t.tangential, t.early,
              t.shared);
  std::fflush(stdout);
}

FitOptions OptionsOf(const Setting& setting) {
  FitOptions options;
  options.distance.weight = setting.distance_weight;
  options.coverage.weight = setting.coverage_weight;
  options.boundary.weight = setting.boundary_weight;
  options.image.views = setting.views;
  return options;
}

}  // namespace

void StudySequences() {
  if (testing::DataDir().empty()) {
    std::fprintf(stderr, "study sequences needs the test data; set CAGEFIT_DATA\n");
    return;
  }
  std::printf(
      "| sequence | images, boundary of | energy | Hausdorff, %% | worst RMS, %% | drift, %% | "
      "along the "
      "surface | first ten | every third frame |\n"
      "| --- | --- | --- | ---: | ---: | ---: | ---: | ---: | ---: |\n");
  for (const std::string name : {"tshirt", "puppet"}) {
    const std::vector<Frame> frames = LoadSequence(name);
    const ControlMesh cage = CageOf(frames[0].truth, kControlVertices);
    const auto print = [&](const Setting& setting, KnownBy of, int stride) {
      const bool is_by_points = setting.views == Views::kNone && setting.boundary_weight == 0;
      const char* what = is_by_points ? "" : of == KnownBy::kMesh ? "meshes" : "points";
      Print(stride == 1 ? name : name + ", every third", what, setting,
            Track(frames, cage, OptionsOf(setting), of, stride));
    };
    for (const Setting& setting :
         {kDistance, kImages, kBoth, kBoundary, kBoundaryToo, kDefault, kAll}) {
      print(setting, KnownBy::kMesh, 1);
    }
    for (const Setting& setting : {kImages, kBoth, kBoundary, kBoundaryToo, kDefault, kAll}) {
      print(setting, KnownBy::kPoints, 1);
    }
    print(kDefault, KnownBy::kMesh, 3);
    print(kAll, KnownBy::kMesh, 3);
  }
}

}  // namespace cagefit::bench
