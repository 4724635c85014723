#include "client/commands/drift_report.h"

#include <string>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "core/base/status.h"
#include "core/subdiv/limit.h"

namespace cagefit::client {
namespace {

constexpr size_t kNone = static_cast<size_t>(-1);

LimitMesh MetricMesh(const ControlMesh& cage) {
  return BuildLimitMesh(cage.topology(), cage.tags(), kMetricLevels);
}

size_t FirstFitted(const FitReport& report) {
  for (size_t k = 0; k < report.frames.size(); ++k) {
    if (report.frames[k].status.ok()) return k;
  }
  return kNone;
}

void PrintStats(const DriftStats& d, double diagonal, std::ostream& out) {
  const double percent = diagonal > 0 ? 100 / diagonal : 0;
  out << absl::StreamFormat(" %9.4f %9.4f %9.4f %9.4f %11.5g %11.5g %11.5g %11.5g\n",
                            percent * d.mean, percent * d.rms, percent * d.max,
                            percent * d.tangential_mean, d.mean, d.rms, d.max, d.tangential_mean);
}

}  // namespace

absl::Status MeasureTrueDrift(const ControlMesh& cage, TrueMotion* truth, FitReport* report) {
  const LimitMesh limit = MetricMesh(cage);
  TriangleMesh fit;
  fit.triangles = limit.triangles;
  std::optional<DriftMeter> meter;
  for (size_t k = 0; k < report->frames.size(); ++k) {
    FrameRecord& frame = report->frames[k];
    if (!frame.status.ok()) continue;
    ApplyStencils(limit.position, frame.control_vertices, &fit.vertices);
    ASSIGN_OR_RETURN(const Points3d points, truth->Vertices(k));
    if (!meter.has_value()) meter.emplace(fit, points);
    frame.drift = meter->Measure(fit.vertices, points);
  }
  return absl::OkStatus();
}

void MeasureRoundTripDrift(const ControlMesh& cage, FitReport* report) {
  const LimitMesh limit = MetricMesh(cage);
  TriangleMesh fit;
  fit.triangles = limit.triangles;
  Points3d returned;
  // The way back begins at the last frame but one.
  for (size_t k = 0; k < report->way_back.size(); ++k) {
    FrameRecord& frame = report->frames[report->frames.size() - 2 - k];
    const FrameRecord& back = report->way_back[k];
    if (!frame.status.ok() || !back.status.ok()) continue;
    ApplyStencils(limit.position, frame.control_vertices, &fit.vertices);
    ApplyStencils(limit.position, back.control_vertices, &returned);
    frame.drift = RoundTripDrift(fit, returned);
  }
}

std::optional<DriftStats> TotalDrift(const FitReport& report) {
  const size_t first = FirstFitted(report);
  if (first == kNone) return std::nullopt;
  if (report.drift_kind == DriftKind::kRoundTrip) return report.frames[first].drift;
  std::vector<DriftStats> measured;
  for (size_t k = first + 1; k < report.frames.size(); ++k) {
    if (report.frames[k].drift.has_value()) measured.push_back(*report.frames[k].drift);
  }
  if (measured.empty()) return std::nullopt;
  return Combine(measured);
}

Json TotalDriftJson(const FitReport& report) {
  if (report.drift_kind == DriftKind::kNone) return nullptr;
  Json json = {
      {"measured", report.drift_kind == DriftKind::kTruth ? "against_true_motion" : "round_trip"}};
  const size_t first = FirstFitted(report);
  if (first != kNone) json["first_frame"] = first;
  const std::optional<DriftStats> total = TotalDrift(report);
  if (total.has_value()) json.update(ToJson(*total, report.diagonal));
  return json;
}

void PrintDriftTable(const FitReport& report, const std::vector<size_t>& rows, std::ostream& out) {
  if (report.drift_kind == DriftKind::kNone) return;
  const bool is_true = report.drift_kind == DriftKind::kTruth;
  const size_t first = FirstFitted(report);
  const std::string from = first == kNone ? "the first frame" : absl::StrCat("frame ", first);
  const std::optional<DriftStats> total = TotalDrift(report);
  if (!total.has_value()) {
    out << (is_true ? "Drift against the true motion" : "Round-trip drift")
        << ": not measured, it takes two fits of the sequence\n";
    return;
  }
  out << (is_true ? "Drift against the true motion since " + from
                  : "Round-trip drift (no true motion given): each frame fitted on the way back "
                    "against its fit on the way there")
      << "\n"
      << absl::StreamFormat("%5s %39s %47s\n", "", "% of the diagonal", "units")
      << absl::StreamFormat("%5s %9s %9s %9s %9s %11s %11s %11s %11s\n", "frame", "mean", "RMS",
                            "max", "along", "mean", "RMS", "max", "along");
  for (const size_t k : rows) {
    if (!report.frames[k].drift.has_value()) continue;
    out << absl::StreamFormat("%5d", k);
    PrintStats(*report.frames[k].drift, report.diagonal, out);
  }
  out << (is_true ? "Over all frames but that one" : "There and back to " + from)
      << " (mean, RMS, max, along the surface; % and units):";
  PrintStats(*total, report.diagonal, out);
  int bad = 0;
  for (const FrameRecord& frame : report.way_back) {
    bad += !frame.status.ok() || frame.reply.verdict() == v1::VERDICT_LOST;
  }
  if (bad > 0) out << "On the way back " << bad << " frames were refused or LOST\n";
}

}  // namespace cagefit::client
