// What the image loss costs: two views, value and gradient, and a whole fit with it.
#include <benchmark/benchmark.h>

#include "core/energy/image_term.h"
#include "core/fit/fitter.h"
#include "core/fit/normalization.h"
#include "core/image/views.h"
#include "tests/bench/scenes.h"
#include "tests/support/shapes.h"

namespace cagefit::bench {
namespace {

void TwoViews(benchmark::State& state, SilhouetteMode mode) {
  const Scene& scene = Sequence();
  const auto normalization = Normalization::FromBox(BoundingBox(scene.clouds[0].points));
  const Points3d V = normalization->ToUnit(scene.cage.vertices());
  const auto m1 = std::make_shared<RefinedSurface>(scene.cage.topology(), scene.cage.tags());
  ImageTerm term(m1, {mode, {}}, /*per_iteration=*/0, /*seed=*/0);
  std::vector<ImageTarget> targets(2);
  const std::vector<Camera> cameras = SphereViews(2, {0, 0, 0}, 0.7, 256);
  for (size_t k = 0; k < 2; ++k) targets[k] = {cameras[k], Image(256, 256), {}, {}, {}};
  term.SetTarget(&targets, {1, 0, 0}, 0);
  Points3d half_gradient = Points3d::Zero(3, V.cols());
  double step = 0;
  for (auto _ : state) {
    step += 1e-9;  // other vertices: the term remembers the last ones
    benchmark::DoNotOptimize(term.Evaluate(V.array() + step));
    term.AddHalfGradient(&half_gradient);
  }
  state.SetLabel(std::to_string(scene.cage.vertex_count()) + " control vertices, " +
                 std::to_string(m1->topology.triangle_count()) + " faces, 256 x 256");
}
void TwoOutlineViews(benchmark::State& state) { TwoViews(state, SilhouetteMode::kOutline); }
void TwoPytorch3dViews(benchmark::State& state) { TwoViews(state, SilhouetteMode::kPytorch3d); }
BENCHMARK(TwoOutlineViews)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK(TwoPytorch3dViews)->Unit(benchmark::kMillisecond)->UseRealTime();

void TwoOutlineViewsOfATorus(benchmark::State& state) {
  const auto across = static_cast<int>(state.range(0));
  const TriangleMesh mesh = testing::Torus(2 * across, across, 0.3, 0.15);
  const MeshEdges edges(mesh.triangles);
  const std::vector<Camera> cameras = SphereViews(2, {0, 0, 0}, 0.5, 256);
  MeshView view;
  Points3d gradient = Points3d::Zero(3, mesh.vertices.cols());
  for (auto _ : state) {
    for (const Camera& camera : cameras) {
      view.Render(mesh.vertices, mesh.triangles, edges, camera, {});
      view.AddGradient(view.silhouette(), &gradient);
    }
  }
  state.SetLabel(std::to_string(mesh.triangles.cols()) + " faces, 256 x 256");
}
BENCHMARK(TwoOutlineViewsOfATorus)
    ->RangeMultiplier(2)
    ->Range(32, 256)
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();

// As WholeFitOfASequenceFrame, with silhouettes of the points from 10 sides.
void WholeFitWithImages(benchmark::State& state) {
  const Scene& scene = Sequence();
  FitOptions options;
  options.image.views = Views::kSphere;
  const auto normalization = Normalization::FromBox(BoundingBox(scene.clouds[0].points));
  auto fitter = Fitter::Create(scene.cage, *normalization, options);
  Points3d start, fitted;
  if (!fitter->Fit(scene.clouds[0], {scene.cage.vertices()}, nullptr, nullptr, &start).ok()) {
    std::abort();
  }
  int iterations = 0;
  for (auto _ : state) {
    const auto summary = fitter->Fit(scene.clouds.back(), {start}, nullptr, nullptr, &fitted,
                                     StartKind::kEarlierFit);
    if (!summary.ok()) std::abort();
    iterations = summary->iterations;
  }
  state.SetLabel(scene.label + ", " + std::to_string(iterations) + " steps");
}
BENCHMARK(WholeFitWithImages)->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace
}  // namespace cagefit::bench
