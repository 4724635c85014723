#include "server/session/session_config.h"

#include <cmath>

#include "absl/strings/str_cat.h"
#include "core/base/status.h"
#include "server/session/error_detail.h"

namespace cagefit::server {

absl::Status SessionConfig::Validate() const {
  if (name.size() > kMaxNameBytes) {
    return InvalidField("name", absl::StrCat(name.size(), " bytes long"), "at most 200 bytes");
  }
  // Negated, so that NaN is refused too.
  if (quantum != 0 && !(quantum >= 1e-9 && quantum <= 1e-2)) {
    return InvalidField("options.quantum", absl::StrCat(quantum), "expected 0, or 1e-9 to 1e-2");
  }
  if (key_interval < 1 || key_interval > 100'000) {
    return InvalidField("options.key_interval", absl::StrCat(key_interval),
                        "expected 1 to 100,000");
  }
  if (!control_mesh.has_value() && template_vertices < 4) {
    return InvalidField("make_template.vertices", absl::StrCat(template_vertices),
                        "expected 4 or more");
  }
  const absl::Status fit_status = fit.Validate();
  if (!fit_status.ok()) {
    return WithDetail(fit_status, {"INVALID_FIELD", "options.fit", "", ""});
  }
  return absl::OkStatus();
}

}  // namespace cagefit::server
