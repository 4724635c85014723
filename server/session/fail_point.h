// Named places where a test makes the server fail. Only in builds with CAGEFIT_FAIL_POINTS, which
// `cagefitd` is not and `cagefitd_faults` is; elsewhere nothing of them is compiled.
//
//   CAGEFIT_FAIL_POINT("session.before_fit", frame.sequence_number);
//
// stands in a function that returns a status. fail_plan.h has the variable that arms them.
#ifndef CAGEFIT_SERVER_SESSION_FAIL_POINT_H_
#define CAGEFIT_SERVER_SESSION_FAIL_POINT_H_

#ifdef CAGEFIT_FAIL_POINTS

#include <cstdint>

#include "absl/status/status.h"
#include "absl/strings/string_view.h"
#include "core/base/status.h"

namespace cagefit::server {

// Does what CAGEFITD_FAIL_POINTS wants to happen at the point `name`, which is passed with `key`
// (the frame's number, where there is a frame). Thread-safe.
absl::Status HitFailPoint(absl::string_view name, uint64_t key);

}  // namespace cagefit::server

#define CAGEFIT_FAIL_POINT(name, key) RETURN_IF_ERROR(::cagefit::server::HitFailPoint(name, key))

#else

#define CAGEFIT_FAIL_POINT(name, key) static_cast<void>(0)

#endif  // CAGEFIT_FAIL_POINTS

#endif  // CAGEFIT_SERVER_SESSION_FAIL_POINT_H_
