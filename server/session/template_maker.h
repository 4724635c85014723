// The seam behind which control meshes are made from a session's first frame.
#ifndef CAGEFIT_SERVER_SESSION_TEMPLATE_MAKER_H_
#define CAGEFIT_SERVER_SESSION_TEMPLATE_MAKER_H_

#include <cstdint>
#include <optional>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "core/base/cancel.h"
#include "core/mesh/control_mesh.h"

namespace cagefit::server {

struct TemplateRequest {
  int32_t vertices = 0;  // within 1 %; 4 or more
  // Edges sharper than this become creases, degrees; 0 to 180, 0: none. Not set: automatic.
  std::optional<double> crease_angle_degrees;
};

// Thread-safe.
class TemplateMaker {
 public:
  virtual ~TemplateMaker() = default;

  // FAILED_PRECONDITION, saying how to get it, when no template can be made here.
  virtual absl::Status CheckAvailable() const = 0;

  // A control mesh from a frame's Draco bytes.
  // INVALID_ARGUMENT when that frame does not give one, RESOURCE_EXHAUSTED at a limit of time or
  // memory, CANCELLED soon after `cancelled` says so.
  virtual absl::StatusOr<ControlMesh> Make(absl::string_view draco, const TemplateRequest& request,
                                           const CancelFn& cancelled) = 0;
};

}  // namespace cagefit::server

#endif  // CAGEFIT_SERVER_SESSION_TEMPLATE_MAKER_H_
