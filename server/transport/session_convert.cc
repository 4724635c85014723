#include "server/transport/session_convert.h"

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "core/base/status.h"
#include "server/session/error_detail.h"
#include "server/transport/fit_options_convert.h"
#include "server/transport/time_convert.h"

namespace cagefit::server {
namespace {

absl::Status ReadOptions(const v1::SessionOptions& proto, SessionConfig* config) {
  ASSIGN_OR_RETURN(config->fit, FromProto(proto.fit()));
  if (proto.has_quantum()) config->quantum = proto.quantum();
  if (proto.has_key_interval()) config->key_interval = proto.key_interval();
  if (proto.tolerance() != 0) {
    config->tolerance = ToleranceOptions{proto.tolerance(), 0};
    if (proto.has_max_vertices()) {
      if (proto.max_vertices() == 0) {
        return InvalidField("options.max_vertices", "0", "expected 4 or more");
      }
      config->tolerance->max_vertices = ClampToInt(proto.max_vertices());
    }
  }
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
      return InvalidField("options.delta_encoding", absl::StrCat(proto.delta_encoding()),
                          "this server does not know that value");
  }
  switch (proto.priority()) {
    case v1::PRIORITY_UNSPECIFIED:
    case v1::PRIORITY_LIVE:
      break;
    case v1::PRIORITY_BATCH:
      config->priority = Priority::kBatch;
      break;
    default:
      return InvalidField("options.priority", absl::StrCat(proto.priority()),
                          "this server does not know that value");
  }
  return absl::OkStatus();
}

absl::Status CheckLength(const std::string& field, int values, int expected) {
  if (values == expected) return absl::OkStatus();
  return InvalidField(field, absl::StrCat(values, " values long"),
                      absl::StrCat("expected ", expected));
}

absl::StatusOr<Camera> ReadCamera(const std::string& field, const v1::Camera& proto) {
  RETURN_IF_ERROR(CheckLength(absl::StrCat(field, ".rotation"), proto.rotation_size(), 9));
  RETURN_IF_ERROR(CheckLength(absl::StrCat(field, ".translation"), proto.translation_size(), 3));
  Camera camera;
  camera.name = proto.name();
  camera.width = ClampToInt(proto.width());
  camera.height = ClampToInt(proto.height());
  camera.fx = proto.fx();
  camera.fy = proto.fy();
  camera.cx = proto.cx();
  camera.cy = proto.cy();
  for (int k = 0; k < 9; ++k) camera.R(k / 3, k % 3) = proto.rotation(k);
  for (int k = 0; k < 3; ++k) camera.t[k] = proto.translation(k);
  camera.distortion = {proto.k1(), proto.k2(), proto.p1(), proto.p2(), proto.k3()};
  return camera;
}

absl::StatusOr<std::vector<Camera>> ReadCameras(const v1::SessionOptions& proto) {
  std::vector<Camera> cameras;
  for (int k = 0; k < proto.cameras_size(); ++k) {
    ASSIGN_OR_RETURN(Camera camera,
                     ReadCamera(absl::StrCat("options.cameras[", k, "]"), proto.cameras(k)));
    cameras.push_back(std::move(camera));
  }
  return cameras;
}

v1::Camera ToProto(const Camera& camera) {
  v1::Camera proto;
  proto.set_name(camera.name);
  proto.set_width(camera.width);
  proto.set_height(camera.height);
  proto.set_fx(camera.fx);
  proto.set_fy(camera.fy);
  proto.set_cx(camera.cx);
  proto.set_cy(camera.cy);
  for (int k = 0; k < 9; ++k) proto.add_rotation(camera.R(k / 3, k % 3));
  for (int k = 0; k < 3; ++k) proto.add_translation(camera.t[k]);
  proto.set_k1(camera.distortion.k1);
  proto.set_k2(camera.distortion.k2);
  proto.set_p1(camera.distortion.p1);
  proto.set_p2(camera.distortion.p2);
  proto.set_k3(camera.distortion.k3);
  return proto;
}

absl::Status CheckMultiple(const char* field, int64_t values, int64_t of) {
  if (values % of == 0) return absl::OkStatus();
  return InvalidField(field, absl::StrCat(values, " values long"),
                      absl::StrCat("expected a multiple of ", of));
}

}  // namespace

absl::StatusOr<ControlMesh> FromProto(const v1::ControlMesh& proto, const SessionLimits& limits) {
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

absl::StatusOr<SessionConfig> FromProto(const v1::CreateSessionRequest& request,
                                        const SessionLimits& limits) {
  SessionConfig config;
  config.name = request.name();
  RETURN_IF_ERROR(ReadOptions(request.options(), &config));
  ASSIGN_OR_RETURN(config.cameras, ReadCameras(request.options()));
  const bool says_views = request.options().fit().image().views() != v1::VIEWS_UNSPECIFIED;
  if (!config.cameras.empty() && !says_views) config.fit.image.views = Views::kCameras;
  switch (request.template_case()) {
    case v1::CreateSessionRequest::kControlMesh: {
      ASSIGN_OR_RETURN(config.control_mesh, FromProto(request.control_mesh(), limits));
      break;
    }
    case v1::CreateSessionRequest::kMakeTemplate:
      config.make_template.vertices = ClampToInt(request.make_template().vertices());
      if (request.make_template().has_crease_angle_degrees()) {
        config.make_template.crease_angle_degrees = request.make_template().crease_angle_degrees();
      }
      break;
    case v1::CreateSessionRequest::TEMPLATE_NOT_SET:
      if (config.tolerance.has_value()) break;
      return InvalidField("template", "not set", "expected control_mesh or make_template");
  }
  if (config.tolerance.has_value() && config.make_template.vertices == 0) {
    config.make_template.vertices = SessionConfig::kToleranceStartVertices;
  }
  return config;
}

v1::SessionOptions ToProto(const SessionConfig& config) {
  v1::SessionOptions options;
  *options.mutable_fit() = ToProto(config.fit);
  options.set_quantum(config.quantum);
  options.set_delta_encoding(config.delta_encoding == DeltaEncoding::kDraco
                                 ? v1::DELTA_ENCODING_DRACO
                                 : v1::DELTA_ENCODING_PACKED);
  options.set_key_interval(config.key_interval);
  if (config.tolerance.has_value()) {
    options.set_tolerance(config.tolerance->tolerance);
    if (config.tolerance->max_vertices > 0) {
      options.set_max_vertices(config.tolerance->max_vertices);
    }
  }
  for (const Camera& camera : config.cameras) *options.add_cameras() = ToProto(camera);
  options.set_priority(config.priority == Priority::kBatch ? v1::PRIORITY_BATCH
                                                           : v1::PRIORITY_LIVE);
  return options;
}

v1::Session ToProto(const SessionLedger& ledger) {
  const SessionFacts facts = ledger.Facts();
  v1::Session session;
  session.set_session_id(ledger.id());
  session.set_name(ledger.config().name);
  *session.mutable_options() = ToProto(ledger.config());
  *session.mutable_created() = ToProto(ledger.created());
  session.set_epoch(facts.epoch);
  session.set_next_sequence_number(facts.next_sequence_number);
  session.set_fitted_frames(facts.fitted_frames);
  session.set_rejected_frames(facts.rejected_frames);
  session.set_control_vertices(facts.control_vertices);
  session.set_triangles(facts.triangles);
  session.set_stream_attached(facts.stream_attached);
  session.set_skipped_frames(facts.skipped_frames);
  session.set_memory_bytes(static_cast<uint64_t>(facts.memory_bytes));
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
