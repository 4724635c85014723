#include "server/session/session_config.h"

#include <cmath>
#include <set>
#include <string>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/strip.h"
#include "core/base/status.h"
#include "server/session/error_detail.h"

namespace cagefit::server {

namespace {

absl::Status CheckRequest(const TemplateRequest& request) {
  if (request.vertices < 4) {
    return InvalidField("make_template.vertices", absl::StrCat(request.vertices),
                        "expected 4 or more");
  }
  const double angle = request.crease_angle_degrees.value_or(0);
  if (angle >= 0 && angle <= 180) return absl::OkStatus();  // false for NaN
  return InvalidField("make_template.crease_angle_degrees", absl::StrCat(angle),
                      "expected 0 to 180");
}

absl::Status CheckTolerance(const ToleranceOptions& tolerance) {
  if (tolerance.max_vertices != 0 && tolerance.max_vertices < 4) {
    return InvalidField("options.max_vertices", absl::StrCat(tolerance.max_vertices),
                        "expected 4 or more");
  }
  if (tolerance.Validate().ok()) return absl::OkStatus();
  return InvalidField("options.tolerance", absl::StrCat(tolerance.tolerance),
                      "expected 0 (off), or 1e-6 to 0.1");
}

// Core calls pose and cameras by other names than a request.
absl::Status InvalidCamera(const std::string& prefix, const std::string& name,
                           absl::string_view message) {
  absl::ConsumePrefix(&message, absl::StrCat("camera \"", name, "\": "));
  const std::string what =
      absl::StartsWith(message, "R is ")   ? absl::StrCat("rotation", message.substr(1))
      : absl::StartsWith(message, "t is ") ? absl::StrCat("translation", message.substr(1))
                                           : std::string(message);
  return InvalidFieldIn(prefix, what);
}

absl::Status CheckCameras(const std::vector<Camera>& cameras) {
  if (cameras.size() > SessionConfig::kMaxCameras) {
    return InvalidField("options.cameras", absl::StrCat(cameras.size(), " long"),
                        absl::StrCat("at most ", SessionConfig::kMaxCameras));
  }
  std::set<std::string> names;
  for (size_t k = 0; k < cameras.size(); ++k) {
    const std::string field = absl::StrCat("options.cameras[", k, "]");
    const std::string& name = cameras[k].name;
    if (name.empty() || name.size() > SessionConfig::kMaxNameBytes) {
      return InvalidField(absl::StrCat(field, ".name"), absl::StrCat(name.size(), " bytes long"),
                          "expected 1 to 200");
    }
    if (!names.insert(name).second) {
      return InvalidField(absl::StrCat(field, ".name"), absl::StrCat("\"", name, "\""),
                          "another camera has it");
    }
    const absl::Status valid = cameras[k].Validate();
    if (!valid.ok()) return InvalidCamera(field + ".", name, valid.message());
  }
  return absl::OkStatus();
}

}  // namespace

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
  RETURN_IF_ERROR(CheckCameras(cameras));
  if (fit.image.views == Views::kCameras && cameras.empty()) {
    return InvalidField("options.fit.image.views", "CAMERAS",
                        "the session has no cameras; expected options.cameras");
  }
  if (!control_mesh.has_value()) RETURN_IF_ERROR(CheckRequest(make_template));
  if (tolerance.has_value()) RETURN_IF_ERROR(CheckTolerance(*tolerance));
  const absl::Status fit_status = fit.Validate();
  if (!fit_status.ok()) return InvalidFieldIn("options.fit.", fit_status.message());
  return absl::OkStatus();
}

}  // namespace cagefit::server
