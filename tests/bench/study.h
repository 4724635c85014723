// What the studies of tests/bench/study.cc share: a model, a fit to it, and how close that came.
#ifndef CAGEFIT_TESTS_BENCH_STUDY_H_
#define CAGEFIT_TESTS_BENCH_STUDY_H_

#include <cstdint>
#include <string>

#include "core/cloud/point_cloud.h"
#include "core/fit/fitter.h"
#include "core/mesh/control_mesh.h"
#include "core/mesh/triangle_mesh.h"
#include "core/metrics/surface_metrics.h"

namespace cagefit::bench {

struct Model {
  std::string name;
  TriangleMesh mesh;
  PointCloud cloud;  // as the target of a fit
};

// A mesh of the test data, by its name there, or a sphere with bumps where there are none. Ends the
// program where the file cannot be read.
Model LoadModel(const std::string& name);

// Of 10 * 4^levels + 2 vertices.
TriangleMesh BumpySphere(int levels);

struct StudyFit {
  TriangleMesh surface;  // limit surface, kMetricLevels
  FitSummary summary;
  double seconds = 0;  // of Fitter::Fit
};

// From the cage's own vertices, in the unit box of the target. Ends the program where that fails.
StudyFit FitTo(const PointCloud& target, const ControlMesh& cage, const FitOptions& options = {});

ControlMesh CageOf(const TriangleMesh& mesh, int32_t vertices);
ControlMesh CageOf(const PointCloud& cloud, int32_t vertices);

double Seconds();  // since some moment

// Each prints a table.
void StudyRobustness();
void StudySolvers();
void StudyScaling();
void StudyVertexCount();
void StudySequences();

}  // namespace cagefit::bench

#endif  // CAGEFIT_TESTS_BENCH_STUDY_H_
