// What came of a fit, frame by frame: report.json and the table on the screen.
#ifndef CAGEFIT_CLIENT_COMMANDS_FIT_REPORT_H_
#define CAGEFIT_CLIENT_COMMANDS_FIT_REPORT_H_

#include <optional>
#include <ostream>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "cagefit/v1/fitting.pb.h"
#include "client/commands/json.h"
#include "core/mesh/control_mesh.h"

namespace cagefit::client {

struct FrameRecord {
  std::string file;                                              // empty: not known
  absl::Status status = absl::UnavailableError("not answered");  // OK: fitted
  v1::FrameReply reply;  // without delta and template, which would fill the memory
  int64_t delta_bytes = 0;
  Points3d control_vertices;               // 3 x n when fitted
  std::optional<DistanceStats> distances;  // exact, of the whole target
  std::optional<DriftStats> drift;         // as FitReport::drift_kind says
};

// What a frame's drift is measured against: the true motion since the first fitted frame, or the
// fit of the same frame on the way back.
enum class DriftKind { kNone, kTruth, kRoundTrip };

struct FitTotals {
  int fitted = 0, skipped = 0, refused = 0, unanswered = 0, suspect = 0, lost = 0;
  bool beyond_tolerance = false;                       // a tolerance was asked for and not met
  double mean_rms_percent = 0, worst_rms_percent = 0;  // of the fitted frames
  double seconds = 0;                                  // from the first byte sent to the last reply
  double frames_per_second = 0;  // from the first reply to the last; 0 with fewer than two
};

struct FitReport {
  std::vector<FrameRecord> frames;
  size_t first_frame = 0;             // those before it were not asked for and do not count
  std::vector<FrameRecord> way_back;  // of a round trip: from the last frame but one to frame 0
  DriftKind drift_kind = DriftKind::kNone;
  v1::Session session;
  Json settings;
  double diagonal = 0;  // of the first target's bounding box
  double seconds = 0, frames_per_second = 0;
};

// Of the first target, as the server measured: from a distance that it gave both ways; 0: unknown.
double SampledDiagonal(const FitReport& report);

// Exact distances from the target (every point; of a mesh, vertices and samples) to the limit
// surface of each fitted frame, at kMetricLevels. Frames whose file cannot be read again keep their
// sampled distances.
void MeasureFrames(const ControlMesh& cage, FitReport* report);

FitTotals Totals(const FitReport& report);

Json FrameJson(const FrameRecord& frame, size_t index, double diagonal);
Json ReportJson(const FitReport& report);

// A line a frame (the worst ones only when there are many) and the totals.
void PrintFitTable(const FitReport& report, std::ostream& out);

}  // namespace cagefit::client

#endif  // CAGEFIT_CLIENT_COMMANDS_FIT_REPORT_H_
