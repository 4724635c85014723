// Options of the fit: between protobuf and core's struct.
#ifndef CAGEFIT_SERVER_TRANSPORT_FIT_OPTIONS_CONVERT_H_
#define CAGEFIT_SERVER_TRANSPORT_FIT_OPTIONS_CONVERT_H_

#include <cstdint>

#include "absl/status/statusor.h"
#include "cagefit/v1/fitting.pb.h"
#include "core/fit/fit_options.h"

namespace cagefit::server {

// What is not set takes the preset's value. INVALID_ARGUMENT naming the field for an enum value
// that is not known; ranges are FitOptions::Validate's to check.
absl::StatusOr<FitOptions> FromProto(const v1::FitOptions& proto);

// Every value in force; no preset.
v1::FitOptions ToProto(const FitOptions& options);

// Values beyond int32 stay out of every range that is checked later.
int32_t ClampToInt(uint32_t value);

}  // namespace cagefit::server

#endif  // CAGEFIT_SERVER_TRANSPORT_FIT_OPTIONS_CONVERT_H_
