#include "server/session/session.h"

#include <algorithm>
#include <cmath>
#include <new>
#include <utility>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "core/base/status.h"
#include "core/fit/normalization.h"
#include "server/session/error_detail.h"
#include "server/session/fail_point.h"
#include "server/session/key_answer.h"

namespace cagefit::server {
namespace {

// These answer the frame for good; all other errors leave it unanswered.
bool Rejects(const absl::Status& status) {
  return absl::IsInvalidArgument(status) || absl::IsInternal(status);
}

StoredFrame Unanswered(const Frame& frame) {
  StoredFrame answer;
  answer.sequence_number = frame.sequence_number;
  answer.timestamp = frame.timestamp;
  answer.digest = frame.digest;
  answer.points = frame.cloud.ok() ? frame.cloud->size() : 0;
  answer.ms.queue = frame.queue_ms;
  answer.ms.decode = frame.decode_ms;
  return answer;
}

absl::Status Diverged(const absl::Status& cause) {
  return WithDetail(
      absl::InternalError(absl::StrCat("the fit of this frame diverged: ", cause.message())),
      {"FIT_DIVERGED", "", "", ""});
}

absl::Status NoMemory(absl::string_view work) {
  return WithDetail(
      absl::ResourceExhaustedError(absl::StrCat("the server has no memory left to ", work)),
      {"LIMIT_EXCEEDED", "memory", "", "", absl::Seconds(1)});
}

absl::Status NoFrame(const std::string& reason, absl::string_view why) {
  return WithDetail(absl::FailedPreconditionError(
                        absl::StrCat("frame is not set, and ", why, "; send one with the request")),
                    {reason, "frame", "", ""});
}

absl::Status CheckLossVertices(const Points3d& vertices, const ControlMesh& mesh) {
  if (vertices.cols() != mesh.vertex_count()) {
    return InvalidField("vertices", absl::StrCat(vertices.cols(), " vertices"),
                        absl::StrCat("the session has ", mesh.vertex_count()));
  }
  for (int64_t k = 0; k < vertices.size(); ++k) {
    if (std::isfinite(vertices.data()[k])) continue;
    return InvalidField(absl::StrCat("vertices[", k, "]"), absl::StrCat(vertices.data()[k]),
                        "expected a finite number");
  }
  return absl::OkStatus();
}

// After these checks a fitter refuses what is too far away, or a target of which cleaning leaves
// too little.
absl::StatusOr<Energies> NamingTheField(absl::StatusOr<Energies> energies) {
  if (!absl::IsInvalidArgument(energies.status())) return energies;
  const bool by_vertices = absl::StartsWith(energies.status().message(), "vertices");
  return WithDetail(energies.status(),
                    {"INVALID_FIELD", by_vertices ? "vertices" : "frame.data", "", ""});
}

absl::Status CheckLandmarks(const Frame& frame, const ControlMesh& mesh) {
  const absl::Status status =
      cagefit::CheckLandmarks(frame.landmarks, mesh.vertex_count(), mesh.triangles().cols());
  if (status.ok()) return status;
  return InvalidFieldIn(absl::StrCat(frame.header_field, "."), status.message());
}

absl::Status PoisonFrame(uint64_t number) {
  return WithDetail(absl::InternalError(absl::StrCat("poison frame: the fit of frame ", number,
                                                     " was begun ", Session::kMostBegun,
                                                     " times, and the server did not survive it")),
                    {"POISON_FRAME", "header.sequence_number", absl::StrCat(number), ""});
}

// Of the target that fixed the session's normalisation and grid.
absl::StatusOr<Box> FirstBox(const SessionLedger& ledger) {
  const uint64_t end = ledger.Facts().next_sequence_number;
  for (uint64_t number = 0; number < end; ++number) {
    ASSIGN_OR_RETURN(const std::shared_ptr<const StoredFrame> answer, ledger.Find(number));
    if (answer != nullptr && answer->first_box.has_value()) return *answer->first_box;
  }
  return absl::DataLossError("no stored frame has the box of the first target");
}

absl::Status SequenceGap(uint64_t number, uint64_t expected) {
  return WithDetail(
      absl::OutOfRangeError(
          absl::StrCat("header.sequence_number is ", number, "; expected ", expected)),
      {"SEQUENCE_GAP", "header.sequence_number", absl::StrCat(number), absl::StrCat(expected)});
}

absl::Status OtherBytes(uint64_t number) {
  return WithDetail(absl::AlreadyExistsError(
                        absl::StrCat("header.sequence_number is ", number,
                                     "; that frame was answered before and had other bytes")),
                    {"SEQUENCE_CONFLICT", "header.sequence_number", absl::StrCat(number), ""});
}

}  // namespace

Session::Session(std::shared_ptr<SessionLedger> ledger, TemplateMaker* templates, ClockFn clock)
    : ledger_(std::move(ledger)), templates_(templates), clock_(std::move(clock)) {}

absl::StatusOr<FrameAnswer> Session::Answer(Frame frame, uint64_t epoch, const CancelFn& cancelled,
                                            const Turns& turns) {
  RETURN_IF_ERROR(ledger_->CheckEpoch(epoch));
  RETURN_IF_ERROR(Restore());
  if (stream_epoch_ != epoch) key_needed_ = true;
  stream_epoch_ = epoch;

  const uint64_t expected = ledger_->Facts().next_sequence_number;
  if (frame.sequence_number < expected) return Repeat(frame.sequence_number, frame.digest);
  if (frame.sequence_number > expected) return SequenceGap(frame.sequence_number, expected);
  RETURN_IF_ERROR(ledger_->CheckRoom());

  ASSIGN_OR_RETURN(const int begun, ledger_->Begin(epoch));
  bool is_counted = true;
  const CancelFn cancelled_in_turn = [&] {
    if (cancelled && cancelled()) return true;
    if (begun > 1 || !turns.is_over || !turns.is_over()) return false;
    // Whatever ends the process meanwhile, it is not this frame.
    ledger_->Abandon(expected).IgnoreError();
    turns.give_way();
    is_counted = ledger_->Begin(epoch).ok();  // if not, the answer will not be stored, either
    return cancelled && cancelled();
  };
  Step step;
  auto answer = AnswerNext(frame, begun, cancelled_in_turn, &step);
  if (!answer.ok()) {
    // What is the end of the stream here has not harmed the process. Where even that cannot be
    // written, the frame has one try less.
    if (is_counted) ledger_->Abandon(expected).IgnoreError();
    return answer.status();
  }
  RETURN_IF_ERROR(Store(epoch, *answer, std::move(step)));
  return FrameAnswer{*std::move(answer)};
}

absl::StatusOr<std::shared_ptr<StoredFrame>> Session::AnswerNext(const Frame& frame, int begun,
                                                                 const CancelFn& cancelled,
                                                                 Step* step) {
  const StoredFrame unanswered = Unanswered(frame);
  auto answer = std::make_shared<StoredFrame>(unanswered);
  answer->outcome = Outcome::kFitted;
  absl::Status fitted;
  try {
    fitted = begun > kMostBegun ? PoisonFrame(frame.sequence_number)
                                : Fit(frame, cancelled, answer.get(), step);
  } catch (const std::bad_alloc&) {
    fitted = NoMemory("fit this frame");
  }
  if (Rejects(fitted)) {
    *answer = unanswered;  // nothing of a fit that came to nothing
    answer->outcome = Outcome::kRejected;
    answer->error = fitted;
  } else {
    RETURN_IF_ERROR(fitted);
  }
  return answer;
}

absl::StatusOr<FrameAnswer> Session::Skip(const SkippedFrame& frame, uint64_t epoch) {
  RETURN_IF_ERROR(ledger_->CheckEpoch(epoch));
  const uint64_t expected = ledger_->Facts().next_sequence_number;
  if (frame.sequence_number < expected) return Repeat(frame.sequence_number, frame.digest);
  if (frame.sequence_number > expected) return SequenceGap(frame.sequence_number, expected);
  RETURN_IF_ERROR(ledger_->CheckRoom());
  auto answer = std::make_shared<StoredFrame>();
  answer->sequence_number = frame.sequence_number;
  answer->timestamp = frame.timestamp;
  answer->digest = frame.digest;
  answer->outcome = Outcome::kSkipped;
  RETURN_IF_ERROR(Store(epoch, answer, Step()));
  return FrameAnswer{std::move(answer)};
}

absl::StatusOr<FrameAnswer> Session::Repeat(uint64_t sequence_number, const Digest& digest) {
  ASSIGN_OR_RETURN(std::shared_ptr<const StoredFrame> stored, ledger_->Find(sequence_number));
  if (stored->digest != digest) return OtherBytes(sequence_number);
  // Who asks again may not know the state before that frame, and does not know the latest one
  // afterwards: this answer and the next new one are key frames.
  if (stored->outcome == Outcome::kFitted) key_needed_ = true;
  ASSIGN_OR_RETURN(std::shared_ptr<const StoredFrame> keyed,
                   KeyAnswer(*ledger_, std::move(stored)));
  return FrameAnswer{std::move(keyed), /*repeated=*/true};
}

absl::Status Session::Fit(const Frame& frame, const CancelFn& cancelled, StoredFrame* answer,
                          Step* step) {
  CAGEFIT_FAIL_POINT("session.before_fit", frame.sequence_number);
  RETURN_IF_ERROR(frame.cloud.status());
  if (!model_.has_value()) {
    ASSIGN_OR_RETURN(step->first_model, MakeModel(frame, cancelled, answer));
  }
  SurfaceModel& model = model_.has_value() ? *model_ : *step->first_model;

  RETURN_IF_ERROR(CheckLandmarks(frame, model.template_mesh()));
  Points3d fitted;
  frame_in_memory_ = false;
  auto summary = model.fitter().Fit(*frame.cloud, track_.Starts(model.template_mesh()), cancelled,
                                    clock_, &fitted, track_.start_kind(), SourceOf(frame));
  if (absl::IsInternal(summary.status())) return Diverged(summary.status());
  RETURN_IF_ERROR(summary.status());
  answer->fit = *summary;
  answer->control_vertices = model.template_mesh().vertex_count();
  answer->ms.index = summary->index_ms;
  answer->ms.solve = summary->solve_ms;

  const double encode_start = clock_();
  RETURN_IF_ERROR(EncodeState(model, fitted, answer, step));
  const double measure_start = clock_();
  answer->ms.encode = measure_start - encode_start;

  // What the client will have is measured, not what the solver had before rounding.
  const Judgement judgement = model.Judge(*frame.cloud, step->state.vertices,
                                          track_.ExpectationOf(answer->fit), answer->fit.radius);
  answer->distances = judgement.distances;
  answer->rms_percent = judgement.rms_percent;
  answer->verdict = judgement.verdict;
  answer->ms.measure = clock_() - measure_start;
  return absl::OkStatus();
}

FrameSource Session::SourceOf(const Frame& frame) const {
  FrameSource source;
  if (frame.mesh.has_value()) source.mesh = &*frame.mesh;
  source.cameras = &ledger_->config().cameras;
  source.masks = &frame.masks;
  source.landmarks = &frame.landmarks;
  source.frame = frame.sequence_number;
  return source;
}

absl::StatusOr<SurfaceModel> Session::MakeModel(const Frame& frame, const CancelFn& cancelled,
                                                StoredFrame* answer) {
  const SessionConfig& config = ledger_->config();
  const double start = clock_();
  answer->first_box = BoundingBox(frame.cloud->points);
  std::optional<ControlMesh> template_mesh = config.control_mesh;
  if (!template_mesh.has_value()) {
    ASSIGN_OR_RETURN(template_mesh,
                     templates_->Make(frame.geometry(), config.make_template, cancelled));
    answer->made_template = true;
    const int32_t most = ledger_->limits().max_control_vertices;
    if (template_mesh->vertex_count() > most) {
      return LimitExceeded("control vertices of the template", template_mesh->vertex_count(), most);
    }
  }
  if (config.tolerance.has_value()) {
    ASSIGN_OR_RETURN(template_mesh, RefineTemplate(*template_mesh, frame, cancelled, answer));
  }
  auto model = SurfaceModel::Create(*template_mesh, *answer->first_box, config);
  answer->ms.template_making = clock_() - start;
  return model;
}

absl::StatusOr<ControlMesh> Session::RefineTemplate(const ControlMesh& start, const Frame& frame,
                                                    const CancelFn& cancelled,
                                                    StoredFrame* answer) const {
  const SessionConfig& config = ledger_->config();
  const PointCloud& target = *frame.cloud;
  ToleranceOptions options = *config.tolerance;
  if (options.max_vertices == 0) {
    options.max_vertices = MostToleranceVertices(target.size());
  }
  options.max_vertices = std::max(
      start.vertex_count(), std::min(options.max_vertices, ledger_->limits().max_control_vertices));
  auto fit = FitToTolerance(start, target, options, config.fit, cancelled);
  if (absl::IsInternal(fit.status())) return Diverged(fit.status());
  RETURN_IF_ERROR(fit.status());
  ToleranceReport report;
  report.end = fit->end;
  report.diagonal = BoundingBox(target.points).diagonal();
  report.tolerance = options.tolerance * report.diagonal;
  report.distances = fit->distances;
  report.control_vertices = fit->mesh.vertex_count();
  report.rounds = fit->rounds;
  answer->tolerance = report;
  answer->made_template = true;
  return std::move(fit->mesh);
}

absl::Status Session::EncodeState(const SurfaceModel& model, const Points3d& fitted,
                                  StoredFrame* answer, Step* step) const {
  const SessionConfig& config = ledger_->config();
  if (config.quantum == 0) {
    const Points3f positions = fitted.cast<float>();
    if (!positions.allFinite()) {
      return Diverged(absl::OutOfRangeError("a control vertex does not fit into float32"));
    }
    step->state.vertices = positions.cast<double>();
    answer->delta = EncodePositions(positions);
    return absl::OkStatus();
  }
  auto q = Quantize(fitted, model.grid());
  if (!q.ok()) return Diverged(q.status());
  step->state.q = *std::move(q);
  step->state.vertices = Dequantize(step->state.q, model.grid());
  const bool key =
      key_needed_ || !model_.has_value() || fitted_since_key_ + 1 >= config.key_interval;
  ASSIGN_OR_RETURN(answer->delta,
                   Encode(key ? EncodeKey(step->state.q) : EncodeDelta(track_.q(), step->state.q),
                          model.grid(), config.delta_encoding));
  return absl::OkStatus();
}

absl::Status Session::Store(uint64_t epoch, const std::shared_ptr<StoredFrame>& answer, Step step) {
  CAGEFIT_FAIL_POINT("session.before_store", answer->sequence_number);
  if (answer->outcome != Outcome::kFitted) {
    return ledger_->Append(epoch, answer, std::nullopt);
  }
  const SurfaceModel& model = model_.has_value() ? *model_ : *step.first_model;
  std::optional<ControlMesh> made_template;
  if (answer->made_template) made_template = model.template_mesh();
  RETURN_IF_ERROR(ledger_->Append(epoch, answer, std::move(made_template)));

  if (step.first_model.has_value()) model_ = std::move(step.first_model);
  track_.Advance(*answer, std::move(step.state));
  frame_in_memory_ = true;
  fitted_since_key_ = answer->delta.key ? 0 : fitted_since_key_ + 1;
  key_needed_ = false;
  return absl::OkStatus();
}

void Session::DropModel() {
  model_.reset();
  frame_in_memory_ = false;
}

absl::Status Session::ReplayTrack() {
  auto track = Track::Replay(*ledger_);
  if (track.ok()) {
    track_ = *std::move(track);
    return absl::OkStatus();
  }
  if (absl::IsUnavailable(track.status())) return track.status();
  return absl::DataLossError(
      absl::StrCat("the stored frames of this session do not replay: ", track.status().message()));
}

absl::Status Session::Restore() {
  if (model_.has_value() || ledger_->Facts().fitted_frames == 0) return absl::OkStatus();
  if (track_.is_empty()) RETURN_IF_ERROR(ReplayTrack());
  ASSIGN_OR_RETURN(const Box first_box, FirstBox(*ledger_));
  ASSIGN_OR_RETURN(const ControlMesh template_mesh, ledger_->TemplateMesh());
  ASSIGN_OR_RETURN(model_, SurfaceModel::Create(template_mesh, first_box, ledger_->config()));
  return absl::OkStatus();
}

absl::StatusOr<Loss> Session::EvaluateLoss(const Points3d& vertices, const Frame* frame,
                                           const CancelFn& cancelled) try {
  if (frame != nullptr) RETURN_IF_ERROR(frame->cloud.status());
  RETURN_IF_ERROR(Restore());
  if (!model_.has_value()) {
    if (frame == nullptr) return NoFrame("NO_FRAME_YET", "the session has fitted none yet");
    return FirstLoss(vertices, *frame, cancelled);
  }
  if (frame == nullptr && !frame_in_memory_) {
    return NoFrame("FRAME_NOT_IN_MEMORY", "the server has the one that was fitted last no more");
  }
  RETURN_IF_ERROR(CheckLossVertices(vertices, model_->template_mesh()));
  if (frame != nullptr) RETURN_IF_ERROR(CheckLandmarks(*frame, model_->template_mesh()));
  Loss loss;
  ASSIGN_OR_RETURN(loss.energies,
                   NamingTheField(model_->fitter().Evaluate(
                       frame != nullptr ? &*frame->cloud : nullptr,
                       track_.Starts(model_->template_mesh()).front(), vertices, cancelled,
                       &loss.gradient, frame != nullptr ? SourceOf(*frame) : FrameSource())));
  return loss;
} catch (const std::bad_alloc&) {
  return NoMemory("evaluate this loss");
}

absl::StatusOr<Loss> Session::FirstLoss(const Points3d& vertices, const Frame& frame,
                                        const CancelFn& cancelled) const {
  const PointCloud& target = *frame.cloud;
  ASSIGN_OR_RETURN(const ControlMesh mesh, ledger_->FinalTemplate());
  RETURN_IF_ERROR(CheckLossVertices(vertices, mesh));
  RETURN_IF_ERROR(CheckLandmarks(frame, mesh));
  ASSIGN_OR_RETURN(const Normalization normalization,
                   Normalization::FromBox(BoundingBox(target.points)));
  ASSIGN_OR_RETURN(Fitter fitter, Fitter::Create(mesh, normalization, ledger_->config().fit));
  Loss loss;
  ASSIGN_OR_RETURN(loss.energies,
                   NamingTheField(fitter.Evaluate(&target, mesh.vertices(), vertices, cancelled,
                                                  &loss.gradient, SourceOf(frame))));
  return loss;
}

}  // namespace cagefit::server
