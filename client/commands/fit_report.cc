#include "client/commands/fit_report.h"

#include <algorithm>

#include "absl/strings/str_format.h"
#include "client/commands/drift_report.h"
#include "client/commands/message_json.h"
#include "client/io/geometry_file.h"
#include "core/metrics/surface_samples.h"
#include "core/subdiv/limit.h"

namespace cagefit::client {
namespace {

constexpr size_t kMostRows = 60;

bool IsFitted(const FrameRecord& frame) { return frame.status.ok(); }

int& CountOf(const FrameRecord& frame, FitTotals* totals) {
  if (frame.reply.outcome() == v1::OUTCOME_SKIPPED) return totals->skipped;
  return absl::IsUnavailable(frame.status) ? totals->unanswered : totals->refused;
}

double RmsPercent(const FrameRecord& frame, double diagonal) {
  if (frame.distances.has_value() && diagonal > 0) return 100 * frame.distances->rms / diagonal;
  return frame.reply.distances().rms_percent();
}

const char* VerdictName(v1::Verdict verdict) {
  switch (verdict) {
    case v1::VERDICT_OK:
      return "ok";
    case v1::VERDICT_SUSPECT:
      return "SUSPECT";
    case v1::VERDICT_LOST:
      return "LOST";
    default:
      return "";
  }
}

void PrintRow(const FrameRecord& frame, size_t index, double diagonal, std::ostream& out) {
  if (!IsFitted(frame)) {
    out << absl::StreamFormat("%5d  %s\n", index, std::string(frame.status.message()));
    return;
  }
  const double scale = diagonal > 0 ? 100 / diagonal : 0;
  const v1::FrameReply& r = frame.reply;
  const double mean = frame.distances ? frame.distances->mean : r.distances().mean();
  const double max = frame.distances ? frame.distances->max : r.distances().max();
  const v1::StageMilliseconds& ms = r.milliseconds();
  out << absl::StreamFormat(
      "%5d %9.4f %9.4f %9.4f %9.4f %8d %6d %8.1f %8.1f %8.1f %8.1f  %s\n", index, scale * mean,
      RmsPercent(frame, diagonal), scale * max, scale * r.noise(), r.outliers(), r.iterations(),
      ms.decode(), ms.index(), ms.solve(), ms.measure() + ms.encode(), VerdictName(r.verdict()));
}

void PrintTolerance(const v1::ToleranceReport& t, std::ostream& out) {
  switch (t.end()) {
    case v1::TOLERANCE_END_WITHIN:
      out << "Within tolerance";
      break;
    case v1::TOLERANCE_END_VERTEX_LIMIT:
      out << "NOT within tolerance, the limit of control vertices is reached";
      break;
    default:
      out << "NOT within tolerance, more control vertices no longer help";
  }
  out << absl::StreamFormat(
      ": %d control vertices after %d fits; %.4f %% (%g) for all points of the first frame but the "
      "farthest 0.1 %%, RMS %.4f %%, at most %.4f %%\n",
      t.control_vertices(), t.rounds(), t.most_percent(), t.most(), t.rms_percent(),
      t.max_percent());
}

}  // namespace

void MeasureFrames(const ControlMesh& cage, FitReport* report) {
  const LimitMesh limit = BuildLimitMesh(cage.topology(), cage.tags(), kMetricLevels);
  Points3d points;
  TriangleBvh surface;
  for (FrameRecord& frame : report->frames) {
    if (!IsFitted(frame)) continue;
    const auto geometry = ReadGeometry(frame.file);
    if (!geometry.ok()) continue;
    ApplyStencils(limit.position, frame.control_vertices, &points);
    surface.Build(points, limit.triangles);
    // Of a mesh, its vertices and as many points in its faces as it has faces.
    const Points3d& vertices = geometry->mesh.vertices;
    const Points3d target =
        geometry->is_cloud() ? vertices : SampleSurface(geometry->mesh, 1, /*seed=*/1);
    frame.distances = DistancesToSurface(target, surface);
    if (report->diagonal == 0) report->diagonal = BoundingBox(target).diagonal();
  }
}

double SampledDiagonal(const FitReport& report) {
  for (const FrameRecord& frame : report.frames) {
    const v1::SampledDistances& d = frame.reply.distances();
    if (IsFitted(frame) && d.rms_percent() > 0) return 100 * d.rms() / d.rms_percent();
  }
  return 0;
}

FitTotals Totals(const FitReport& report) {
  FitTotals totals;
  totals.seconds = report.seconds;
  totals.frames_per_second = report.frames_per_second;
  for (size_t k = report.first_frame; k < report.frames.size(); ++k) {
    const FrameRecord& frame = report.frames[k];
    if (!IsFitted(frame)) {
      ++CountOf(frame, &totals);
      continue;
    }
    ++totals.fitted;
    totals.suspect += frame.reply.verdict() == v1::VERDICT_SUSPECT;
    totals.lost += frame.reply.verdict() == v1::VERDICT_LOST;
    totals.beyond_tolerance |=
        frame.reply.has_tolerance() && frame.reply.tolerance().end() != v1::TOLERANCE_END_WITHIN;
    const double rms = RmsPercent(frame, report.diagonal);
    totals.mean_rms_percent += rms;
    totals.worst_rms_percent = std::max(totals.worst_rms_percent, rms);
  }
  if (totals.fitted > 0) totals.mean_rms_percent /= totals.fitted;
  return totals;
}

Json FrameJson(const FrameRecord& frame, size_t index, double diagonal) {
  Json json = {{"frame", index}};
  if (!frame.file.empty()) json["file"] = frame.file;
  if (!IsFitted(frame)) {
    json["error"] = {{"code", absl::StatusCodeToString(frame.status.code())},
                     {"message", std::string(frame.status.message())}};
    return json;
  }
  json.update(ToJson(frame.reply));
  for (const char* key : {"delta", "template", "error", "repeated_reply"}) json.erase(key);
  json["sampled_distances"] = std::move(json["distances"]);
  json.erase("distances");
  if (frame.distances.has_value()) json["distances"] = ToJson(*frame.distances, diagonal);
  if (frame.drift.has_value()) json["drift"] = ToJson(*frame.drift, diagonal);
  json["delta_bytes"] = frame.delta_bytes;
  return json;
}

Json ReportJson(const FitReport& report) {
  const FitTotals totals = Totals(report);
  Json json = {{"cagefit", CAGEFIT_VERSION}, {"settings", report.settings}};
  json["session"] = ToJson(report.session);
  json["total"] = {{"frames", report.frames.size() - report.first_frame},
                   {"fitted", totals.fitted},
                   {"skipped", totals.skipped},
                   {"refused", totals.refused},
                   {"unanswered", totals.unanswered},
                   {"suspect", totals.suspect},
                   {"lost", totals.lost},
                   {"beyond_tolerance", totals.beyond_tolerance},
                   {"diagonal", report.diagonal},
                   {"mean_rms_percent", totals.mean_rms_percent},
                   {"worst_rms_percent", totals.worst_rms_percent},
                   {"seconds", totals.seconds},
                   {"frames_per_second", totals.frames_per_second}};
  const Json drift = TotalDriftJson(report);
  if (!drift.is_null()) json["total"]["drift"] = drift;
  json["frames"] = Json::array();
  for (size_t k = report.first_frame; k < report.frames.size(); ++k) {
    json["frames"].push_back(FrameJson(report.frames[k], k, report.diagonal));
  }
  for (size_t k = 0; k < report.way_back.size(); ++k) {
    const size_t index = report.frames.size() - 2 - k;
    json["way_back"].push_back(FrameJson(report.way_back[k], index, report.diagonal));
  }
  return json;
}

void PrintFitTable(const FitReport& report, std::ostream& out) {
  std::vector<size_t> rows;
  for (size_t k = report.first_frame; k < report.frames.size(); ++k) rows.push_back(k);
  if (rows.size() > kMostRows) {
    // Refused and lost frames first, then by distance.
    const auto badness = [&](size_t k) {
      const FrameRecord& frame = report.frames[k];
      return IsFitted(frame) ? RmsPercent(frame, report.diagonal) : 1e300;
    };
    std::stable_sort(rows.begin(), rows.end(),
                     [&](size_t a, size_t b) { return badness(a) > badness(b); });
    rows.resize(kMostRows);
    std::sort(rows.begin(), rows.end());
    out << "The " << kMostRows << " worst of " << report.frames.size() - report.first_frame
        << " frames:\n";
  }
  out << "       distance, % of the diagonal        noise, %                   milliseconds\n"
      << absl::StreamFormat("%5s %9s %9s %9s %9s %8s %6s %8s %8s %8s %8s\n", "frame", "mean", "RMS",
                            "max", "of it", "outliers", "steps", "decode", "index", "solve",
                            "rest");
  for (const size_t k : rows) PrintRow(report.frames[k], k, report.diagonal, out);
  const FitTotals totals = Totals(report);
  out << absl::StreamFormat(
      "%d of %d frames fitted, %d skipped, %d refused, %d suspect, %d lost; RMS %.4f %% on "
      "average, %.4f %% at "
      "worst; %.1f s",
      totals.fitted, report.frames.size() - report.first_frame, totals.skipped, totals.refused,
      totals.suspect, totals.lost, totals.mean_rms_percent, totals.worst_rms_percent,
      totals.seconds);
  if (totals.frames_per_second > 0) {
    out << absl::StreamFormat(", %.1f frames a second", totals.frames_per_second);
  }
  out << "\n";
  PrintDriftTable(report, rows, out);
  for (const FrameRecord& frame : report.frames) {
    if (IsFitted(frame) && frame.reply.has_tolerance())
      PrintTolerance(frame.reply.tolerance(), out);
  }
}

}  // namespace cagefit::client
