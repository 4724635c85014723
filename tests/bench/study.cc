// Studies of the fit, each a table of the README: study robustness | sequences | solvers | scaling
// | vertices.
#include "tests/bench/study.h"

#include <chrono>
#include <cstdio>
#include <iostream>
#include <utility>

#include "absl/strings/string_view.h"
#include "client/io/geometry_file.h"
#include "core/cloud/surface_cloud.h"
#include "core/subdiv/limit.h"
#include "core/template/template_maker.h"
#include "tests/support/data.h"
#include "tests/support/shapes.h"

namespace cagefit::bench {
namespace {

template <typename Value>
Value OrDie(absl::StatusOr<Value> value) {
  if (value.ok()) return *std::move(value);
  std::cerr << value.status() << "\n";
  std::exit(EXIT_FAILURE);
}

}  // namespace

TriangleMesh BumpySphere(int levels) {
  TriangleMesh mesh = testing::Icosphere(levels);
  for (int64_t v = 0; v < mesh.vertices.cols(); ++v) {
    const Eigen::Vector3d x = mesh.vertices.col(v);
    mesh.vertices.col(v) *= 1 + 0.1 * std::sin(5 * x[0]) * std::sin(4 * x[1]) + 0.2 * x[2] * x[0];
  }
  return mesh;
}

Model LoadModel(const std::string& name) {
  Model model;
  Points3f normals(3, 0);
  if (testing::DataDir().empty()) {
    model = {"bumpy sphere", BumpySphere(6), {}};
  } else {
    client::Geometry geometry = OrDie(client::ReadGeometry(testing::DataDir() + "/" + name));
    model = {name, std::move(geometry.mesh), {}};
    normals = geometry.normals;
  }
  model.cloud = SurfaceCloud(model.mesh, normals);
  return model;
}

double Seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

StudyFit FitTo(const PointCloud& target, const ControlMesh& cage, const FitOptions& options) {
  const Normalization normalization = OrDie(Normalization::FromBox(BoundingBox(target.points)));
  Fitter fitter = OrDie(Fitter::Create(cage, normalization, options));
  StudyFit fit;
  Points3d fitted;
  const double begin = Seconds();
  fit.summary = OrDie(fitter.Fit(target, {cage.vertices()}, nullptr, nullptr, &fitted));
  fit.seconds = Seconds() - begin;
  const LimitMesh limit = BuildLimitMesh(cage.topology(), cage.tags(), kMetricLevels);
  ApplyStencils(limit.position, fitted, &fit.surface.vertices);
  fit.surface.triangles = limit.triangles;
  return fit;
}

ControlMesh CageOf(const TriangleMesh& mesh, int32_t vertices) {
  TemplateReport report;
  return OrDie(TemplateFromMesh(mesh, {vertices, {}}, &report));
}

ControlMesh CageOf(const PointCloud& cloud, int32_t vertices) {
  TemplateReport report;
  return OrDie(TemplateFromCloud(cloud, {vertices, {}}, &report));
}

}  // namespace cagefit::bench

int main(int count, char** arguments) {
  namespace bench = cagefit::bench;
  constexpr std::pair<absl::string_view, void (*)()> kStudies[] = {
      {"robustness", bench::StudyRobustness},
      {"sequences", bench::StudySequences},
      {"solvers", bench::StudySolvers},
      {"scaling", bench::StudyScaling},
      {"vertices", bench::StudyVertexCount}};
  for (const auto& [name, run] : kStudies) {
    if (count != 2 || name != arguments[1]) continue;
    run();
    return EXIT_SUCCESS;
  }
  std::fprintf(stderr, "usage: study robustness | sequences | solvers | scaling | vertices\n");
  return 2;
}
