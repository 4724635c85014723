// One benchmark for each hot part of a frame.
#include <benchmark/benchmark.h>

#include "core/cloud/imls.h"
#include "core/codec/draco_codec.h"
#include "core/fit/fitter.h"
#include "core/fit/gauss_newton.h"
#include "core/fit/normalization.h"
#include "core/fit/objective.h"
#include "core/fit/step_system.h"
#include "core/subdiv/limit.h"
#include "tests/bench/scenes.h"

namespace cagefit::bench {
namespace {

void DracoDecode(benchmark::State& state) {
  const Scene& scene = Sequence();
  for (auto _ : state) {
    auto cloud = DecodeDracoCloud(scene.frames[0], DecodeLimits());
    benchmark::DoNotOptimize(cloud);
  }
  state.SetLabel(scene.label);
}
BENCHMARK(DracoDecode)->Unit(benchmark::kMillisecond)->UseRealTime();

void IndexBuild(benchmark::State& state) {
  const Scene& scene = Sequence();
  TargetIndex index;
  for (auto _ : state) {
    if (!index.Build(scene.clouds[0], 0, DistanceOptions().radius_factor).ok()) std::abort();
  }
  state.SetLabel(scene.label);
}
BENCHMARK(IndexBuild)->Unit(benchmark::kMillisecond)->UseRealTime();

// The second frame in unit coordinates, with the objective of a fit that starts from the first.
struct Problem {
  explicit Problem(const Scene& scene)
      : normalization(*Normalization::FromBox(BoundingBox(scene.clouds[0].points))),
        V(normalization.ToUnit(scene.cage.vertices())),
        objective(scene.cage.topology(),
                  BuildLimitMesh(scene.cage.topology(), scene.cage.tags(), 1).position,
                  kArapWeightPerVertex * scene.cage.vertex_count()),
        system(objective) {
    cloud = scene.clouds.back();
    cloud.points =
        ((cloud.points.cast<double>().colwise() - normalization.center) * normalization.scale)
            .cast<float>();
    if (!index.Build(cloud, 0, DistanceOptions().radius_factor).ok()) std::abort();
    objective.SetRest(V);
    objective.SetTarget(&index, 3 * index.radius());
    objective.Assign(V, &half_gradient);
    ApplyStencils(objective.stencils(), V, &samples);
  }

  Normalization normalization;
  Points3d V, half_gradient, samples, step;
  PointCloud cloud;
  TargetIndex index;
  Objective objective;
  StepSystem system;
};

void ImlsPass(benchmark::State& state) {
  Problem problem(Sequence());
  double sum = 0;
  for (auto _ : state) {
    for (Eigen::Index i = 0; i < problem.samples.cols(); ++i) {
      sum +=
          EvaluateImls(problem.index.grid(), problem.samples.col(i), problem.index.radius()).value;
    }
  }
  benchmark::DoNotOptimize(sum);
  state.SetLabel(std::to_string(problem.samples.cols()) + " samples, one thread");
}
BENCHMARK(ImlsPass)->Unit(benchmark::kMillisecond)->UseRealTime();

void EnergyAndGradient(benchmark::State& state) {
  Problem problem(Sequence());
  for (auto _ : state) {
    benchmark::DoNotOptimize(problem.objective.Evaluate(problem.V, &problem.half_gradient));
  }
  state.SetLabel("all threads");
}
BENCHMARK(EnergyAndGradient)->Unit(benchmark::kMillisecond)->UseRealTime();

void NormalEquations(benchmark::State& state) {
  Problem problem(Sequence());
  for (auto _ : state) problem.system.Linearize(problem.objective);
}
BENCHMARK(NormalEquations)->Unit(benchmark::kMillisecond)->UseRealTime();

void GaussNewtonStep(benchmark::State& state) {
  Problem problem(Sequence());
  double promised = 0;
  int iterations = 0;
  for (auto _ : state) {
    problem.objective.Evaluate(problem.V, &problem.half_gradient);
    problem.system.Linearize(problem.objective);
    iterations = problem.system.Solve(problem.half_gradient, 1e-5, 0.1, 400, nullptr, &problem.step,
                                      &promised);
  }
  state.SetLabel(std::to_string(iterations) + " conjugate gradient iterations");
}
BENCHMARK(GaussNewtonStep)->Unit(benchmark::kMillisecond)->UseRealTime();

// The last cloud of a scene, from its cage or, in a sequence, from the fit to the frame before.
void WholeFit(benchmark::State& state, const Scene& scene) {
  const auto normalization = Normalization::FromBox(BoundingBox(scene.clouds[0].points));
  auto fitter = Fitter::Create(scene.cage, *normalization, FitOptions());
  Points3d start = scene.cage.vertices(), fitted;
  for (size_t k = 0; k + 1 < scene.clouds.size(); ++k) {
    if (!fitter->Fit(scene.clouds[k], {start}, nullptr, nullptr, &fitted).ok()) std::abort();
    start = fitted;
  }
  int iterations = 0;
  for (auto _ : state) {
    const auto summary = fitter->Fit(scene.clouds.back(), {start}, nullptr, nullptr, &fitted);
    if (!summary.ok()) std::abort();
    iterations = summary->iterations;
  }
  state.SetLabel(scene.label + ", " + std::to_string(iterations) + " steps");
}
void WholeFitOfASequenceFrame(benchmark::State& state) { WholeFit(state, Sequence()); }
void WholeFitStatic(benchmark::State& state) { WholeFit(state, Static()); }
BENCHMARK(WholeFitOfASequenceFrame)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK(WholeFitStatic)->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace
}  // namespace cagefit::bench
