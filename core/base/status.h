// Macros for functions that return absl::Status or absl::StatusOr<T>.
#ifndef CAGEFIT_CORE_BASE_STATUS_H_
#define CAGEFIT_CORE_BASE_STATUS_H_

#include <utility>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

#define CAGEFIT_STATUS_CONCAT_INNER(a, b) a##b
#define CAGEFIT_STATUS_CONCAT(a, b) CAGEFIT_STATUS_CONCAT_INNER(a, b)

// Returns from the enclosing function when `expression` is not OK.
#define RETURN_IF_ERROR(expression)                          \
  do {                                                       \
    absl::Status status_macro_value = (expression);          \
    if (!status_macro_value.ok()) return status_macro_value; \
  } while (false)

// Declares or assigns `lhs` from a StatusOr, or returns its error.
#define ASSIGN_OR_RETURN(lhs, expression) \
  CAGEFIT_ASSIGN_OR_RETURN(CAGEFIT_STATUS_CONCAT(status_or_, __LINE__), lhs, expression)
#define CAGEFIT_ASSIGN_OR_RETURN(statusor, lhs, expression) \
  auto statusor = (expression);                             \
  if (!statusor.ok()) return std::move(statusor).status();  \
  lhs = *std::move(statusor)

#endif  // CAGEFIT_CORE_BASE_STATUS_H_
