#include <iostream>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "client/commands/command.h"
#include "client/commands/input_files.h"
#include "client/commands/json.h"
#include "client/commands/true_motion.h"
#include "client/io/geometry_file.h"
#include "client/limit_surface.h"
#include "core/base/status.h"

namespace cagefit::client {
namespace {

struct EvaluateArguments {
  std::string cages, targets, truth;
  int levels = kMetricLevels;
  bool json = false;
};

struct Evaluated {
  std::string cage, target;
  SurfaceMetrics distances;
  std::optional<DriftStats> drift;
};

absl::StatusOr<SurfaceMetrics> Compare(const TriangleMesh& fit, const std::string& target) {
  ASSIGN_OR_RETURN(const Geometry geometry, ReadGeometry(target));
  if (!geometry.is_cloud()) return CompareToMesh(fit, geometry.mesh);
  return CompareToCloud(fit, ToCloud(geometry));
}

absl::Status CheckSameNumber(size_t cages, size_t targets) {
  if (cages == targets) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrCat(cages, " control meshes but ", targets, " targets; expected as many"));
}

// Frame by frame; drift is measured against the first one.
class Evaluation {
 public:
  explicit Evaluation(const EvaluateArguments& arguments) : arguments_(arguments) {}

  absl::StatusOr<std::vector<Evaluated>> Run() {
    ASSIGN_OR_RETURN(const std::vector<std::string> cages, ListInputs({arguments_.cages}));
    ASSIGN_OR_RETURN(const std::vector<std::string> targets, ListInputs({arguments_.targets}));
    RETURN_IF_ERROR(CheckSameNumber(cages.size(), targets.size()));
    std::optional<TrueMotion> truth;
    if (!arguments_.truth.empty()) {
      ASSIGN_OR_RETURN(truth, TrueMotion::Open({arguments_.truth}, cages.size()));
    }
    std::vector<Evaluated> frames;
    for (size_t k = 0; k < cages.size(); ++k) {
      ASSIGN_OR_RETURN(const ControlMesh cage, ReadControlMesh(cages[k]));
      const TriangleMesh fit = LimitSurface(cage, arguments_.levels);
      Evaluated frame;
      frame.cage = cages[k];
      frame.target = targets[k];
      ASSIGN_OR_RETURN(frame.distances, Compare(fit, targets[k]));
      if (truth.has_value()) {
        ASSIGN_OR_RETURN(const Points3d points, truth->Vertices(k));
        ASSIGN_OR_RETURN(frame.drift, MeasureDrift(cages[k], fit, points));
      }
      frames.push_back(std::move(frame));
    }
    return frames;
  }

 private:
  absl::StatusOr<DriftStats> MeasureDrift(const std::string& cage, const TriangleMesh& fit,
                                          const Points3d& truth) {
    if (!meter_.has_value()) {
      fit_triangles_ = fit.triangles;
      meter_.emplace(fit, truth);
    }
    if (fit.triangles.cols() != fit_triangles_.cols() || fit.triangles != fit_triangles_) {
      return absl::InvalidArgumentError(absl::StrCat(
          cage, ": its limit surface has ", fit.triangles.cols(), " triangles, the first one's ",
          fit_triangles_.cols(), "; drift needs one connectivity for all frames"));
    }
    return meter_->Measure(fit.vertices, truth);
  }

  const EvaluateArguments& arguments_;
  std::optional<DriftMeter> meter_;
  Triangles fit_triangles_;  // of the first frame
};

Json FramesJson(const std::vector<Evaluated>& frames) {
  Json json = Json::array();
  for (const Evaluated& frame : frames) {
    Json entry = {{"cage", frame.cage}, {"target", frame.target}};
    entry["distances"] = ToJson(frame.distances);
    if (frame.drift.has_value()) {
      entry["drift"] = ToJson(*frame.drift, frames.front().distances.diagonal);
    }
    json.push_back(std::move(entry));
  }
  return json;
}

void PrintRow(const char* name, const DistanceStats& stats, const SurfaceMetrics& metrics) {
  std::cout << absl::StreamFormat("%-28s %10.4f %10.4f %10.4f %12.6g\n", name,
                                  metrics.Percent(stats.mean), metrics.Percent(stats.rms),
                                  metrics.Percent(stats.max), stats.rms);
}

void PrintTable(const std::vector<Evaluated>& frames) {
  const double diagonal = frames.front().distances.diagonal;
  for (const Evaluated& frame : frames) {
    const SurfaceMetrics& d = frame.distances;
    std::cout << frame.cage << " against " << frame.target << "\n"
              << absl::StreamFormat("%-28s %10s %10s %10s %12s\n", "  % of the diagonal", "mean",
                                    "RMS", "max", "RMS (units)");
    PrintRow("  target to fit", d.target_to_fit, d);
    PrintRow(d.approximate ? "  fit to target (approximate)" : "  fit to target", d.fit_to_target,
             d);
    if (!frame.drift.has_value()) continue;
    const double scale = diagonal > 0 ? 100 / diagonal : 0;
    std::cout << absl::StreamFormat("%-28s %10.4f %10.4f %10.4f %12.6g\n", "  drift",
                                    scale * frame.drift->mean, scale * frame.drift->rms,
                                    scale * frame.drift->max, frame.drift->rms);
  }
}

int Evaluate(const EvaluateArguments& arguments) {
  const auto frames = Evaluation(arguments).Run();
  if (!frames.ok()) {
    Report(frames.status());
    return kFailed;
  }
  if (arguments.json) {
    std::cout << Text(FramesJson(*frames), 2) << "\n";
  } else {
    PrintTable(*frames);
  }
  return kDone;
}

}  // namespace

void AddEvaluateCommand(CLI::App* app, Run* run) {
  const auto arguments = std::make_shared<EvaluateArguments>();
  CLI::App* command = app->add_subcommand(
      "evaluate", "Measure the distance between a control mesh's limit surface and a target");
  command->add_option("CAGE", arguments->cages, "Control mesh, or a folder of them, one a frame")
      ->required();
  command->add_option("TARGET", arguments->targets, "Mesh or cloud, or a folder of as many")
      ->required();
  command->add_option("--truth", arguments->truth,
                      "Folder of meshes whose vertices correspond from frame to frame: measures "
                      "drift");
  command->add_option("--levels", arguments->levels, "Refinement levels of the limit surface")
      ->capture_default_str()
      ->check(CLI::Range(0, 6));
  command->add_flag("--json", arguments->json, "Print JSON");
  command->callback([arguments, run] { *run = [arguments] { return Evaluate(*arguments); }; });
}

}  // namespace cagefit::client
