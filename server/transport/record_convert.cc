#include "server/transport/record_convert.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "absl/strings/str_cat.h"
#include "cagefit/v1/record.pb.h"
#include "core/base/status.h"
#include "server/transport/reply_convert.h"
#include "server/transport/session_convert.h"
#include "server/transport/status_convert.h"
#include "server/transport/time_convert.h"

namespace cagefit::server {
namespace {

absl::Status Broken(absl::string_view what) {
  return absl::DataLossError(absl::StrCat("a stored ", what, " cannot be read"));
}

template <typename Message>
bool Parse(absl::string_view bytes, Message* message) {
  return message->ParseFromArray(bytes.data(), static_cast<int>(bytes.size()));
}

// Sessions that were accepted once are taken as they are.
SessionLimits NoLimits() {
  SessionLimits limits;
  limits.max_control_vertices = std::numeric_limits<int32_t>::max();
  return limits;
}

EncodedDelta ReadDelta(const v1::VertexDelta& proto) {
  EncodedDelta delta;
  delta.key = proto.key();
  delta.grid.origin = {proto.origin_x(), proto.origin_y(), proto.origin_z()};
  delta.grid.quantum = proto.quantum();
  delta.values.resize(3, proto.packed_size() / 3);
  std::copy_n(proto.packed().begin(), delta.values.size(), delta.values.data());
  delta.draco = proto.draco();
  delta.positions.resize(3, proto.positions_size() / 3);
  std::copy_n(proto.positions().begin(), delta.positions.size(), delta.positions.data());
  delta.checksum = proto.crc32c();
  return delta;
}

Energies ReadEnergies(const v1::Energies& proto) {
  Energies energies;
  energies.distance = proto.distance();
  energies.arap = proto.arap();
  energies.coverage = proto.coverage();
  energies.image = proto.image();
  energies.landmarks = proto.landmarks();
  energies.boundary = proto.boundary();
  return energies;
}

StageTimes ReadTimes(const v1::StageMilliseconds& proto) {
  return {proto.queue(), proto.decode(),  proto.template_(), proto.index(),
          proto.solve(), proto.measure(), proto.encode()};
}

FitSummary ReadSummary(const v1::FrameRecord& record) {
  const v1::FrameReply& reply = record.reply();
  FitSummary fit;
  fit.initial = ReadEnergies(reply.initial_energies());
  fit.final = ReadEnergies(reply.final_energies());
  fit.start = record.start();
  fit.iterations = static_cast<int>(reply.iterations());
  fit.converged = reply.converged();
  fit.radius = reply.radius();
  fit.radius_in_spacings = reply.radius_in_spacings();
  fit.grown_samples = static_cast<int>(reply.grown_samples());
  fit.far_samples = static_cast<int>(reply.far_samples());
  fit.images = record.images();
  fit.samples = record.samples();
  fit.noise = reply.noise();
  fit.outliers = static_cast<int64_t>(reply.outliers());
  fit.index_ms = reply.milliseconds().index();
  fit.solve_ms = reply.milliseconds().solve();
  return fit;
}

// On the wire an enumerator has the number of the session's plus one: 0 is "not set".
template <typename Enum>
constexpr Enum FromTheWire(int value) {
  return static_cast<Enum>(value - 1);
}
static_assert(FromTheWire<Verdict>(v1::VERDICT_OK) == Verdict::kOk);
static_assert(FromTheWire<Verdict>(v1::VERDICT_SUSPECT) == Verdict::kSuspect);
static_assert(FromTheWire<Verdict>(v1::VERDICT_LOST) == Verdict::kLost);
static_assert(FromTheWire<Outcome>(v1::OUTCOME_FITTED) == Outcome::kFitted);
static_assert(FromTheWire<Outcome>(v1::OUTCOME_REJECTED) == Outcome::kRejected);
static_assert(FromTheWire<Outcome>(v1::OUTCOME_SKIPPED) == Outcome::kSkipped);
static_assert(FromTheWire<ToleranceEnd>(v1::TOLERANCE_END_WITHIN) == ToleranceEnd::kWithin);
static_assert(FromTheWire<ToleranceEnd>(v1::TOLERANCE_END_VERTEX_LIMIT) ==
              ToleranceEnd::kVertexLimit);
static_assert(FromTheWire<ToleranceEnd>(v1::TOLERANCE_END_NO_FURTHER) == ToleranceEnd::kNoFurther);

ToleranceReport ReadTolerance(const v1::ToleranceReport& proto, double diagonal) {
  ToleranceReport report;
  report.end = FromTheWire<ToleranceEnd>(proto.end());
  report.tolerance = proto.tolerance();
  report.distances = {proto.rms(), proto.most(), proto.max()};
  report.diagonal = diagonal;
  report.control_vertices = static_cast<int32_t>(proto.control_vertices());
  report.rounds = static_cast<int>(proto.rounds());
  return report;
}

void ReadFit(const v1::FrameRecord& record, StoredFrame* frame) {
  const v1::FrameReply& reply = record.reply();
  frame->delta = ReadDelta(reply.delta());
  frame->fit = ReadSummary(record);
  const v1::SampledDistances& distances = reply.distances();
  frame->distances = {distances.mean(), distances.rms(), distances.max(),
                      distances.uncovered_share(), static_cast<int>(distances.samples())};
  frame->rms_percent = distances.rms_percent();
  frame->verdict = FromTheWire<Verdict>(reply.verdict());
  frame->control_vertices = static_cast<int32_t>(reply.control_vertices());
  frame->made_template = record.made_template();
  if (reply.has_tolerance()) {
    frame->tolerance = ReadTolerance(reply.tolerance(), record.tolerance_diagonal());
  }
  if (record.first_box_size() == 6) {
    const auto& box = record.first_box();
    frame->first_box = Box{{box[0], box[1], box[2]}, {box[3], box[4], box[5]}};
  }
}

}  // namespace

std::string ProtoRecordCodec::EncodeConfig(const SessionConfig& config) const {
  v1::CreateSessionRequest request;
  request.set_name(config.name);
  *request.mutable_options() = ToProto(config);
  request.mutable_make_template()->set_vertices(config.make_template.vertices);
  if (config.make_template.crease_angle_degrees.has_value()) {
    request.mutable_make_template()->set_crease_angle_degrees(
        *config.make_template.crease_angle_degrees);
  }
  return request.SerializeAsString();
}

absl::StatusOr<SessionConfig> ProtoRecordCodec::DecodeConfig(absl::string_view bytes) const {
  v1::CreateSessionRequest request;
  if (!Parse(bytes, &request)) return Broken("configuration");
  auto config = FromProto(request, NoLimits());
  if (!config.ok()) return Broken(absl::StrCat("configuration (", config.status().message(), ")"));
  return config;
}

std::string ProtoRecordCodec::EncodeMesh(const ControlMesh& mesh) const {
  return ToProto(mesh).SerializeAsString();
}

absl::StatusOr<ControlMesh> ProtoRecordCodec::DecodeMesh(absl::string_view bytes) const {
  v1::ControlMesh proto;
  if (!Parse(bytes, &proto)) return Broken("control mesh");
  auto mesh = FromProto(proto, NoLimits());
  if (!mesh.ok()) return Broken(absl::StrCat("control mesh (", mesh.status().message(), ")"));
  return mesh;
}

std::string ProtoRecordCodec::EncodeFrame(const StoredFrame& frame) const {
  v1::FrameRecord record;
  *record.mutable_reply() = ToProto(frame);
  record.set_digest(frame.digest.data(), frame.digest.size());
  if (frame.first_box.has_value()) {
    for (const Eigen::Vector3d& corner : {frame.first_box->min, frame.first_box->max}) {
      record.mutable_first_box()->Add(corner.data(), corner.data() + 3);
    }
  }
  record.set_start(frame.fit.start);
  record.set_images(frame.fit.images);
  record.set_samples(frame.fit.samples);
  record.set_made_template(frame.made_template);
  if (frame.tolerance.has_value()) record.set_tolerance_diagonal(frame.tolerance->diagonal);
  return record.SerializeAsString();
}

absl::StatusOr<std::shared_ptr<const StoredFrame>> ProtoRecordCodec::DecodeFrame(
    absl::string_view bytes) const {
  v1::FrameRecord record;
  if (!Parse(bytes, &record)) return Broken("answer");
  const v1::FrameReply& reply = record.reply();
  auto frame = std::make_shared<StoredFrame>();
  if (record.digest().size() != frame->digest.size()) return Broken("answer (its digest)");
  frame->sequence_number = reply.sequence_number();
  if (reply.has_timestamp()) frame->timestamp = FromProto(reply.timestamp());
  std::copy(record.digest().begin(), record.digest().end(), frame->digest.begin());
  frame->points = static_cast<int64_t>(reply.points());
  frame->ms = ReadTimes(reply.milliseconds());
  switch (reply.outcome()) {
    case v1::OUTCOME_FITTED:
      frame->outcome = Outcome::kFitted;
      ReadFit(record, frame.get());
      break;
    case v1::OUTCOME_REJECTED:
      frame->outcome = Outcome::kRejected;
      frame->error = FromProto(reply.error());
      break;
    case v1::OUTCOME_SKIPPED:
      frame->outcome = Outcome::kSkipped;
      break;
    default:
      return Broken("answer (its outcome)");
  }
  return frame;
}

}  // namespace cagefit::server
