#include "server/transport/session_convert.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "absl/strings/str_cat.h"
#include "core/base/status.h"
#include "server/session/error_detail.h"
#include "server/transport/time_convert.h"

namespace cagefit::server {
namespace {

// Values beyond int32 stay out of every range that is checked later.
int32_t ToInt(uint32_t value) {
  return static_cast<int32_t>(std::min<uint32_t>(value, std::numeric_limits<int32_t>::max()));
}

absl::Status UnknownValue(const char* field, int value) {
  return InvalidField(field, absl::StrCat(value), "this server does not know that value");
}

absl::Status ReadEnums(const v1::FitOptions& proto, FitOptions* options) {
  switch (proto.sampling()) {
    case v1::SAMPLING_UNSPECIFIED:
      break;
    case v1::SAMPLING_CONTROL_VERTICES:
      options->distance.sampling = Sampling::kControlVertices;
      break;
    case v1::SAMPLING_REFINED_VERTICES:
      options->distance.sampling = Sampling::kRefinedVertices;
      break;
    default:
      return UnknownValue("options.fit.sampling", proto.sampling());
  }
  switch (proto.rest_mesh()) {
    case v1::REST_MESH_UNSPECIFIED:
      break;
    case v1::REST_MESH_TEMPLATE:
      options->arap.rest = RestMesh::kTemplate;
      break;
    case v1::REST_MESH_PREVIOUS_FRAME:
      options->arap.rest = RestMesh::kPreviousFrame;
      break;
    default:
      return UnknownValue("options.fit.rest_mesh", proto.rest_mesh());
  }
  switch (proto.solver()) {
    case v1::SOLVER_UNSPECIFIED:
      break;
    case v1::SOLVER_GAUSS_NEWTON:
      options->solver.solver = Solver::kGaussNewton;
      break;
    case v1::SOLVER_CERES:
      options->solver.solver = Solver::kCeres;
      break;
    default:
      return UnknownValue("options.fit.solver", proto.solver());
  }
  return absl::OkStatus();
}

absl::Status ReadFitOptions(const v1::FitOptions& proto, FitOptions* options) {
  RETURN_IF_ERROR(ReadEnums(proto, options));
  if (proto.has_radius()) options->distance.radius = proto.radius();
  if (proto.has_radius_factor()) options->distance.radius_factor = proto.radius_factor();
  if (proto.has_far_radius()) options->distance.far_radius = proto.far_radius();
  if (proto.has_arap_weight()) options->arap.weight = proto.arap_weight();
  if (proto.has_max_iterations()) options->solver.max_iterations = ToInt(proto.max_iterations());
  if (proto.has_relative_decrease()) {
    options->solver.relative_decrease = proto.relative_decrease();
  }
  if (proto.has_first_stiffness()) options->solver.first_stiffness = proto.first_stiffness();
  return absl::OkStatus();
}

absl::Status ReadOptions(const v1::SessionOptions& proto, SessionConfig* config) {
  RETURN_IF_ERROR(ReadFitOptions(proto.fit(), &config->fit));
  if (proto.has_quantum()) config->quantum = proto.quantum();
  if (proto.has_key_interval()) config->key_interval = proto.key_interval();
  switch (proto.delta_encoding()) {
    case v1::DELTA_ENCODING_UNSPECIFIED:
      break;
    case v1::DELTA_ENCODING_PACKED:
      config->delta_encoding = DeltaEncoding::kPacked;
      break;
    case v1::DELTA_ENCODING_DRACO:
      config->delta_encoding = DeltaEncoding::kDraco;
      break;
    default:
      return UnknownValue("options.delta_encoding", proto.delta_encoding());
  }
  return absl::OkStatus();
}

absl::Status CheckMultiple(const char* field, int64_t values, int64_t of) {
  if (values % of == 0) return absl::OkStatus();
  return InvalidField(field, absl::StrCat(values, " values long"),
                      absl::StrCat("expected a multiple of ", of));
}

absl::StatusOr<ControlMesh> ReadControlMesh(const v1::ControlMesh& proto,
                                            const SessionLimits& limits) {
  RETURN_IF_ERROR(CheckMultiple("control_mesh.vertices", proto.vertices_size(), 3));
  RETURN_IF_ERROR(CheckMultiple("control_mesh.triangles", proto.triangles_size(), 3));
  RETURN_IF_ERROR(CheckMultiple("control_mesh.crease_edges", proto.crease_edges_size(), 2));
  const int64_t n = proto.vertices_size() / 3;
  if (n > limits.max_control_vertices) {
    return LimitExceeded("control vertices", n, limits.max_control_vertices);
  }
  // Indices beyond int32 turn negative, which is out of range too.
  Points3d vertices(3, n);
  std::copy(proto.vertices().begin(), proto.vertices().end(), vertices.data());
  Triangles triangles(3, proto.triangles_size() / 3);
  std::copy(proto.triangles().begin(), proto.triangles().end(), triangles.data());
  CreaseTags tags;
  for (int k = 0; k < proto.crease_edges_size(); k += 2) {
    tags.edges.push_back({static_cast<int32_t>(proto.crease_edges(k)),
                          static_cast<int32_t>(proto.crease_edges(k + 1))});
  }
  tags.corners.assign(proto.corners().begin(), proto.corners().end());
  auto mesh = ControlMesh::Create(std::move(vertices), std::move(triangles), std::move(tags));
  if (mesh.ok()) return mesh;
  return WithDetail(mesh.status(), {"INVALID_CONTROL_MESH", "control_mesh", "", ""});
}

v1::FitOptions ToProto(const FitOptions& options) {
  v1::FitOptions proto;
  proto.set_sampling(options.distance.sampling == Sampling::kControlVertices
                         ? v1::SAMPLING_CONTROL_VERTICES
                         : v1::SAMPLING_REFINED_VERTICES);
  proto.set_radius(options.distance.radius);
  proto.set_radius_factor(options.distance.radius_factor);
  proto.set_far_radius(options.distance.far_radius);
  if (options.arap.weight.has_value()) proto.set_arap_weight(*options.arap.weight);
  proto.set_rest_mesh(options.arap.rest == RestMesh::kTemplate ? v1::REST_MESH_TEMPLATE
                                                               : v1::REST_MESH_PREVIOUS_FRAME);
  proto.set_solver(options.solver.solver == Solver::kCeres ? v1::SOLVER_CERES
                                                           : v1::SOLVER_GAUSS_NEWTON);
  proto.set_max_iterations(options.solver.max_iterations);
  proto.set_relative_decrease(options.solver.relative_decrease);
  proto.set_first_stiffness(options.solver.first_stiffness);
  return proto;
}

}  // namespace

absl::StatusOr<SessionConfig> FromProto(const v1::CreateSessionRequest& request,
                                        const SessionLimits& limits) {
  SessionConfig config;
  config.name = request.name();
  RETURN_IF_ERROR(ReadOptions(request.options(), &config));
  switch (request.template_case()) {
    case v1::CreateSessionRequest::kControlMesh: {
      ASSIGN_OR_RETURN(config.control_mesh, ReadControlMesh(request.control_mesh(), limits));
      break;
    }
    case v1::CreateSessionRequest::kMakeTemplate:
      config.template_vertices = ToInt(request.make_template().vertices());
      break;
    case v1::CreateSessionRequest::TEMPLATE_NOT_SET:
      return InvalidField("template", "not set", "expected control_mesh or make_template");
  }
  return config;
}

v1::Session ToProto(const SessionLedger& ledger) {
  const SessionFacts facts = ledger.Facts();
  const SessionConfig& config = ledger.config();
  v1::Session session;
  session.set_session_id(ledger.id());
  session.set_name(config.name);
  *session.mutable_options()->mutable_fit() = ToProto(config.fit);
  session.mutable_options()->set_quantum(config.quantum);
  session.mutable_options()->set_delta_encoding(config.delta_encoding == DeltaEncoding::kDraco
                                                    ? v1::DELTA_ENCODING_DRACO
                                                    : v1::DELTA_ENCODING_PACKED);
  session.mutable_options()->set_key_interval(config.key_interval);
  *session.mutable_created() = ToProto(ledger.created());
  session.set_epoch(facts.epoch);
  session.set_next_sequence_number(facts.next_sequence_number);
  session.set_fitted_frames(facts.fitted_frames);
  session.set_rejected_frames(facts.rejected_frames);
  session.set_control_vertices(facts.control_vertices);
  session.set_triangles(facts.triangles);
  session.set_stream_attached(facts.stream_attached);
  return session;
}

v1::ControlMesh ConnectivityToProto(const ControlMesh& mesh) {
  v1::ControlMesh proto;
  const Triangles& triangles = mesh.triangles();
  proto.mutable_triangles()->Add(triangles.data(), triangles.data() + triangles.size());
  for (const auto& edge : mesh.tags().edges) {
    proto.mutable_crease_edges()->Add(edge.begin(), edge.end());
  }
  proto.mutable_corners()->Add(mesh.tags().corners.begin(), mesh.tags().corners.end());
  return proto;
}

v1::ControlMesh ToProto(const ControlMesh& mesh) {
  v1::ControlMesh proto = ConnectivityToProto(mesh);
  const Points3d& vertices = mesh.vertices();
  proto.mutable_vertices()->Add(vertices.data(), vertices.data() + vertices.size());
  return proto;
}

}  // namespace cagefit::server
