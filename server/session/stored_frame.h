// The answer to a frame, as it is kept: a repeated frame gets it again.
#ifndef CAGEFIT_SERVER_SESSION_STORED_FRAME_H_
#define CAGEFIT_SERVER_SESSION_STORED_FRAME_H_

#include <cstdint>
#include <optional>
#include <string>

#include "absl/status/status.h"
#include "absl/time/time.h"
#include "core/base/types.h"
#include "core/codec/vertex_delta.h"
#include "core/fit/fitter.h"
#include "core/fit/tolerance_fit.h"
#include "core/metrics/verdict.h"
#include "server/session/digest.h"
#include "server/session/session_config.h"

namespace cagefit::server {

enum class Outcome {
  kFitted,
  kRejected,
  kSkipped,  // a newer frame came before this one was begun
};

// How the control vertices follow from those of the fitted frame before. One of `values`, `draco`
// and `positions` is filled.
struct EncodedDelta {
  bool key = false;
  VertexGrid grid;
  GridPoints values;      // 3 x n
  std::string draco;      // the same integers, compressed
  Points3f positions;     // 3 x n, user units, where the session has no grid
  uint32_t checksum = 0;  // CRC-32C of q after this delta, or of the positions

  int64_t StoredBytes() const;
};

struct StageTimes {  // milliseconds
  double queue = 0, decode = 0, template_making = 0, index = 0, solve = 0, measure = 0, encode = 0;
};

// What tolerance mode came to.
struct ToleranceReport {
  ToleranceEnd end = ToleranceEnd::kWithin;
  double tolerance = 0;  // user units, as the distances
  DistanceExtent distances;
  double diagonal = 0;  // of the frame
  int32_t control_vertices = 0;
  int rounds = 0;
};

struct StoredFrame {
  uint64_t sequence_number = 0;
  std::optional<absl::Time> timestamp;
  Digest digest{};
  int64_t points = 0;
  Outcome outcome = Outcome::kRejected;
  absl::Status error;  // when rejected
  StageTimes ms;

  // When fitted.
  EncodedDelta delta;
  FitSummary fit;
  SampledDistances distances;
  double rms_percent = 0;  // of the first target's diagonal
  Verdict verdict = Verdict::kOk;
  int32_t control_vertices = 0;
  bool made_template = false;  // the session's template was made or refined by this frame
  std::optional<ToleranceReport> tolerance;
  std::optional<Box> first_box;  // of the target's points, with the session's first fitted frame

  int64_t StoredBytes() const;
};

// Where the control vertices are after a fitted frame.
struct SurfaceState {
  Points3d vertices;  // as the client has them
  GridPoints q;       // the same on the grid, where the session has one
};

// Samples that the target's points do not surround as densely as elsewhere, as a share.
double BareShare(const FitSummary& fit);

// Integers as the session sends them. INTERNAL when the compressor fails.
absl::StatusOr<EncodedDelta> Encode(const VertexDelta& delta, const VertexGrid& grid,
                                    DeltaEncoding encoding);
// Positions for a session without a grid.
EncodedDelta EncodePositions(const Points3f& positions);

// Back from what was stored. `vertices` bounds what a compressed delta may hold.
absl::StatusOr<VertexDelta> Decode(const EncodedDelta& delta, int64_t vertices);

}  // namespace cagefit::server

#endif  // CAGEFIT_SERVER_SESSION_STORED_FRAME_H_
