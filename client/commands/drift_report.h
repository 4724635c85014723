// Drift of a fitted sequence (core/metrics/drift.h) in report.json and on the screen.
#ifndef CAGEFIT_CLIENT_COMMANDS_DRIFT_REPORT_H_
#define CAGEFIT_CLIENT_COMMANDS_DRIFT_REPORT_H_

#include <optional>
#include <ostream>
#include <vector>

#include "absl/status/status.h"
#include "client/commands/fit_report.h"
#include "client/commands/json.h"
#include "client/commands/true_motion.h"
#include "core/mesh/control_mesh.h"

namespace cagefit::client {

// Drift of every fitted frame against `truth` since the first fitted one, to which its vertices are
// bound. Errors as TrueMotion's; frames before the bad one are then measured.
absl::Status MeasureTrueDrift(const ControlMesh& cage, TrueMotion* truth, FitReport* report);

// Of every frame that was fitted on the way there and on the way back.
void MeasureRoundTripDrift(const ControlMesh& cage, FitReport* report);

// Against the true motion: of all fitted frames but the first, which has none. By round trip: of
// the first fitted frame, where the whole way lies between the two fits. Empty where nothing was
// measured.
std::optional<DriftStats> TotalDrift(const FitReport& report);

// What was measured and the totals; null when no drift was asked for.
Json TotalDriftJson(const FitReport& report);

// A line for each of the frames `rows` and one for the totals, in percent of the first frame's
// diagonal and in units. Prints nothing when no drift was asked for.
void PrintDriftTable(const FitReport& report, const std::vector<size_t>& rows, std::ostream& out);

}  // namespace cagefit::client

#endif  // CAGEFIT_CLIENT_COMMANDS_DRIFT_REPORT_H_
