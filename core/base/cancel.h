// Cooperative cancellation: long computations ask between steps.
#ifndef CAGEFIT_CORE_BASE_CANCEL_H_
#define CAGEFIT_CORE_BASE_CANCEL_H_

#include <functional>

namespace cagefit {

// Returns true once the caller no longer wants the result. May be empty (never cancelled). Called
// from the thread that runs the computation, at least once per solver step.
using CancelFn = std::function<bool()>;

inline bool IsCancelled(const CancelFn& cancelled) { return cancelled && cancelled(); }

}  // namespace cagefit

#endif  // CAGEFIT_CORE_BASE_CANCEL_H_
