#include "server/transport/loss_convert.h"

#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"
#include "core/base/status.h"
#include "server/session/error_detail.h"
#include "server/transport/frame_assembler.h"
#include "server/transport/reply_convert.h"

namespace cagefit::server {

v1::Stencils ToProto(const ExportedStencils& stencils) {
  const StencilMatrix& S = stencils.S;
  v1::Stencils proto;
  proto.set_rows(static_cast<uint32_t>(S.rows()));
  proto.set_columns(static_cast<uint32_t>(S.cols()));
  proto.mutable_row_begin()->Add(S.outerIndexPtr(), S.outerIndexPtr() + S.rows() + 1);
  proto.mutable_column()->Add(S.innerIndexPtr(), S.innerIndexPtr() + S.nonZeros());
  proto.mutable_value()->Add(S.valuePtr(), S.valuePtr() + S.nonZeros());
  const Triangles& triangles = stencils.triangles;
  proto.mutable_triangles()->Add(triangles.data(), triangles.data() + triangles.size());
  return proto;
}

absl::StatusOr<LossQuery> FromProto(v1::EvaluateLossRequest* request) {
  LossQuery query;
  query.session_id = request->session_id();
  if (request->vertices_size() % 3 != 0) {
    return InvalidField("vertices", absl::StrCat(request->vertices_size(), " values long"),
                        "expected three for each control vertex");
  }
  query.vertices.resize(3, request->vertices_size() / 3);
  std::copy(request->vertices().begin(), request->vertices().end(), query.vertices.data());
  if (!request->has_frame()) return query;
  v1::LossFrame& proto = *request->mutable_frame();
  RETURN_IF_ERROR(CheckEncoding("frame.encoding", proto.encoding()));
  Frame& frame = query.frame.emplace();
  frame.bytes = std::move(*proto.mutable_data());
  frame.point_count = proto.point_count();
  frame.stated_masks = FromProto(proto.masks());
  ASSIGN_OR_RETURN(frame.landmarks, LandmarksFromProto("frame.landmarks", proto.landmarks()));
  frame.header_field = "frame";
  frame.bytes_field = "frame.data";
  return query;
}

v1::EvaluateLossReply ToProto(const Loss& loss) {
  v1::EvaluateLossReply reply;
  *reply.mutable_energies() = ToProto(loss.energies);
  reply.set_total(loss.energies.total());
  reply.mutable_gradient()->Add(loss.gradient.data(), loss.gradient.data() + loss.gradient.size());
  return reply;
}

}  // namespace cagefit::server
