// Gauss-Newton against Adam on one energy, from one start.
#include <cstdio>

#include "tests/bench/study.h"

namespace cagefit::bench {
namespace {

constexpr double kRates[] = {1e-4, 3e-4, 1e-3, 3e-3, 1e-2};

void Compare(const Model& model, int32_t vertices) {
  const ControlMesh cage = CageOf(model.mesh, vertices);
  FitOptions options;
  options.distance.first_radius = 1;
  FitOptions adam = options;
  adam.solver.solver = Solver::kAdam;
  adam.solver.max_iterations = 1000;
  adam.solver.relative_decrease = 1e-12;  // all of them
  double best = 0, rate = 0, seconds = 0;
  for (const double candidate : kRates) {
    adam.solver.learning_rate = candidate;
    const StudyFit fit = FitTo(model.cloud, cage, adam);
    const double energy = fit.summary.final.total();
    if (rate > 0 && energy >= best) continue;
    best = energy;
    rate = candidate;
    seconds = fit.seconds;
  }
  // The loosest tolerance of these that gets as low.
  StudyFit newton;
  for (const double tolerance : {1e-3, 1e-4, 3e-5, 1e-5, 1e-6}) {
    options.solver.relative_decrease = tolerance;
    newton = FitTo(model.cloud, cage, options);
    if (newton.summary.final.total() <= best) break;
  }
  std::printf("| %s, %d | %.5g | %g | %.2f s | %.5g | %g | %d | %.2f s | %.1f |\n",
              model.name.c_str(), cage.vertex_count(), best, rate, seconds,
              newton.summary.final.total(), options.solver.relative_decrease,
              newton.summary.iterations, newton.seconds, seconds / newton.seconds);
  std::fflush(stdout);
}

}  // namespace

void StudySolvers() {
  std::printf(
      "| model, control vertices | Adam, 1,000 steps: energy | rate | time | Gauss-Newton: energy "
      "| "
      "relative decrease | steps | time | times faster |\n"
      "| --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: |\n");
  const Model bunny = LoadModel("static/bunny_closed_34835.ply");
  for (const int32_t vertices : {4667, 20'000}) Compare(bunny, vertices);
}

}  // namespace cagefit::bench
