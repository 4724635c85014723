// How close a fit comes with how many control vertices.
#include <cstdio>

#include "tests/bench/study.h"

namespace cagefit::bench {

void StudyVertexCount() {
  std::printf(
      "| control vertices | RMS, %% | Hausdorff, %% | RMS of the paper's settings, %% | Hausdorff, "
      "%% "
      "|\n| ---: | ---: | ---: | ---: | ---: |\n");
  const Model model = LoadModel("static/bunny_closed_34835.ply");
  for (const int32_t vertices : {100, 200, 314, 500, 1000, 2000, 4667, 10'000, 20'000}) {
    const ControlMesh cage = CageOf(model.mesh, vertices);
    std::printf("| %d |", cage.vertex_count());
    for (const FitOptions& options : {FitOptions(), FitOptions::Paper()}) {
      const SurfaceMetrics metrics =
          CompareToMesh(FitTo(model.cloud, cage, options).surface, model.mesh);
      std::printf(" %.4f | %.3f |", metrics.Percent(metrics.symmetric_rms()),
                  metrics.Percent(metrics.hausdorff()));
      std::fflush(stdout);
    }
    std::printf("\n");
  }
}

}  // namespace cagefit::bench
