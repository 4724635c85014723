#include "server/transport/reply_convert.h"

#include <utility>

#include "server/transport/session_convert.h"
#include "server/transport/status_convert.h"
#include "server/transport/time_convert.h"

namespace cagefit::server {
namespace {

v1::Verdict ToProto(Verdict verdict) {
  switch (verdict) {
    case Verdict::kOk:
      return v1::VERDICT_OK;
    case Verdict::kSuspect:
      return v1::VERDICT_SUSPECT;
    case Verdict::kLost:
      return v1::VERDICT_LOST;
  }
  return v1::VERDICT_UNSPECIFIED;
}

void Fill(const EncodedDelta& delta, v1::VertexDelta* proto) {
  proto->set_key(delta.key);
  proto->set_origin_x(delta.grid.origin.x());
  proto->set_origin_y(delta.grid.origin.y());
  proto->set_origin_z(delta.grid.origin.z());
  proto->set_quantum(delta.grid.quantum);
  proto->mutable_packed()->Add(delta.values.data(), delta.values.data() + delta.values.size());
  proto->set_draco(delta.draco);
  proto->mutable_positions()->Add(delta.positions.data(),
                                  delta.positions.data() + delta.positions.size());
  proto->set_crc32c(delta.checksum);
}

void Fill(const StoredFrame& frame, v1::SampledDistances* proto) {
  proto->set_mean(frame.distances.mean);
  proto->set_rms(frame.distances.rms);
  proto->set_max(frame.distances.max);
  proto->set_rms_percent(frame.rms_percent);
  proto->set_uncovered_share(frame.distances.uncovered_share);
  proto->set_samples(frame.distances.samples);
}

void Fill(const StageTimes& ms, v1::StageMilliseconds* proto) {
  proto->set_queue(ms.queue);
  proto->set_decode(ms.decode);
  proto->set_template_(ms.template_making);
  proto->set_index(ms.index);
  proto->set_solve(ms.solve);
  proto->set_measure(ms.measure);
  proto->set_encode(ms.encode);
}

v1::ToleranceEnd ToProto(ToleranceEnd end) {
  switch (end) {
    case ToleranceEnd::kWithin:
      return v1::TOLERANCE_END_WITHIN;
    case ToleranceEnd::kVertexLimit:
      return v1::TOLERANCE_END_VERTEX_LIMIT;
    case ToleranceEnd::kNoFurther:
      return v1::TOLERANCE_END_NO_FURTHER;
  }
  return v1::TOLERANCE_END_UNSPECIFIED;
}

void Fill(const ToleranceReport& report, v1::ToleranceReport* proto) {
  const double percent = 100 / report.diagonal;
  proto->set_end(ToProto(report.end));
  proto->set_tolerance(report.tolerance);
  proto->set_rms(report.distances.rms);
  proto->set_most(report.distances.most);
  proto->set_max(report.distances.max);
  proto->set_rms_percent(percent * report.distances.rms);
  proto->set_most_percent(percent * report.distances.most);
  proto->set_max_percent(percent * report.distances.max);
  proto->set_control_vertices(report.control_vertices);
  proto->set_rounds(report.rounds);
}

void FillFit(const StoredFrame& frame, v1::FrameReply* reply) {
  Fill(frame.delta, reply->mutable_delta());
  *reply->mutable_initial_energies() = server::ToProto(frame.fit.initial);
  *reply->mutable_final_energies() = server::ToProto(frame.fit.final);
  reply->set_iterations(frame.fit.iterations);
  reply->set_converged(frame.fit.converged);
  Fill(frame, reply->mutable_distances());
  reply->set_verdict(ToProto(frame.verdict));
  reply->set_radius(frame.fit.radius);
  reply->set_radius_in_spacings(frame.fit.radius_in_spacings);
  reply->set_grown_samples(frame.fit.grown_samples);
  reply->set_far_samples(frame.fit.far_samples);
  reply->set_noise(frame.fit.noise);
  reply->set_outliers(frame.fit.outliers);
  reply->set_control_vertices(frame.control_vertices);
  if (frame.tolerance.has_value()) Fill(*frame.tolerance, reply->mutable_tolerance());
}

}  // namespace

v1::Energies ToProto(const Energies& energies) {
  v1::Energies proto;
  proto.set_distance(energies.distance);
  proto.set_arap(energies.arap);
  proto.set_coverage(energies.coverage);
  proto.set_image(energies.image);
  proto.set_landmarks(energies.landmarks);
  proto.set_boundary(energies.boundary);
  return proto;
}

v1::FrameReply ToProto(const StoredFrame& frame) {
  v1::FrameReply reply;
  reply.set_sequence_number(frame.sequence_number);
  if (frame.timestamp.has_value()) *reply.mutable_timestamp() = ToProto(*frame.timestamp);
  if (frame.outcome == Outcome::kSkipped) {
    reply.set_outcome(v1::OUTCOME_SKIPPED);
    return reply;
  }
  reply.set_points(frame.points);
  Fill(frame.ms, reply.mutable_milliseconds());
  if (frame.outcome == Outcome::kRejected) {
    reply.set_outcome(v1::OUTCOME_REJECTED);
    *reply.mutable_error() = ToProto(frame.error);
    return reply;
  }
  reply.set_outcome(v1::OUTCOME_FITTED);
  FillFit(frame, &reply);
  return reply;
}

v1::FrameReply ToProto(const FrameAnswer& answer, const SessionLedger& ledger) {
  v1::FrameReply reply = ToProto(*answer.frame);
  reply.set_repeated_reply(answer.repeated);
  if (answer.frame->made_template) {
    const auto mesh = ledger.TemplateMesh();
    v1::ControlMesh connectivity = mesh.ok() ? ConnectivityToProto(*mesh) : v1::ControlMesh();
    if (connectivity.ByteSizeLong() <= kMaxTemplateInReplyBytes) {
      *reply.mutable_template_() = std::move(connectivity);
    }
  }
  return reply;
}

}  // namespace cagefit::server
