// Any CreateSessionRequest: refused with a detail, or a session whose options in force make the
// same session again.
#include "server/session/error_detail.h"
#include "server/transport/session_convert.h"
#include "tests/fuzz/fuzz_target.h"
#include "tests/support/frames.h"
#include "tests/support/masks.h"

namespace cagefit::testing {
namespace {

server::SessionLimits SmallLimits() {
  server::SessionLimits limits;
  limits.max_control_vertices = 200;
  return limits;
}

v1::CreateSessionRequest RequestOf(const ControlMesh& mesh) {
  v1::CreateSessionRequest request;
  *request.mutable_control_mesh() = server::ToProto(mesh);
  return request;
}

// What a session reports as its options makes the same session.
void CheckReport(const server::SessionConfig& config, const v1::CreateSessionRequest& request) {
  v1::CreateSessionRequest again = request;
  *again.mutable_options() = server::ToProto(config);
  const auto config_again = server::FromProto(again, SmallLimits());
  FUZZ_CHECK(config_again.ok());
  FUZZ_CHECK(config_again->Validate().ok());
  FUZZ_CHECK(server::ToProto(*config_again).SerializeAsString() ==
             again.options().SerializeAsString());
}

}  // namespace

std::vector<std::string> FuzzSeeds() {
  v1::CreateSessionRequest plain = RequestOf(FrameCage(0)), rich = plain, made;
  rich.set_name("a rig");
  for (const uint32_t v : {rich.control_mesh().triangles(0), rich.control_mesh().triangles(1)}) {
    rich.mutable_control_mesh()->add_crease_edges(v);
    rich.mutable_control_mesh()->add_corners(v);
  }
  v1::Camera* camera = rich.mutable_options()->add_cameras();
  camera->set_name("left");
  camera->set_width(4);
  camera->set_height(3);
  camera->set_fx(5);
  camera->set_fy(5);
  for (const int k : {1, 0, 0, 0, 1, 0, 0, 0, 1}) camera->add_rotation(k);
  for (const int k : {0, 0, 3}) camera->add_translation(k);
  v1::FitOptions* fit = rich.mutable_options()->mutable_fit();
  fit->set_solver(v1::SOLVER_ADAM);
  fit->set_kernel(v1::KERNEL_TUKEY);
  fit->set_radius(0.5);
  fit->mutable_image()->set_sigma(1e-3);
  rich.mutable_options()->set_quantum(1e-4);
  rich.mutable_options()->set_delta_encoding(v1::DELTA_ENCODING_DRACO);
  made.mutable_make_template()->set_vertices(100);
  made.mutable_options()->set_tolerance(0.01);
  made.mutable_options()->set_max_vertices(150);
  made.mutable_options()->mutable_fit()->set_preset(v1::PRESET_PAPER);
  return {plain.SerializeAsString(), rich.SerializeAsString(), made.SerializeAsString()};
}

}  // namespace cagefit::testing

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace cagefit;
  using namespace cagefit::testing;
  v1::CreateSessionRequest request;
  if (!request.ParseFromArray(data, static_cast<int>(size))) return 0;
  const auto config = server::FromProto(request, SmallLimits());
  const absl::Status status = config.ok() ? config->Validate() : config.status();
  if (status.ok()) {
    CheckReport(*config, request);
    return 0;
  }
  FUZZ_CHECK(absl::IsInvalidArgument(status) || absl::IsResourceExhausted(status));
  FUZZ_CHECK(server::DetailOf(status).has_value());
  FUZZ_CHECK(!server::DetailOf(status)->field.empty());
  return 0;
}
