// What is to fail, where and when.
//
//   CAGEFITD_FAIL_POINTS="seed=7,store.before_commit=kill@3,session.before_fit=error:UNAVAILABLE@p0.1"
//
// Entries are POINT=ACTION[@WHEN], separated by commas; of several for one point each counts for
// itself.
//   ACTION  kill (SIGKILL), abort, error:CODE (a status of that code), delay:MILLISECONDS
//   WHEN    N: the N-th time that the point is passed, from 1; pX: with probability X;
//           #K: each time that it is passed with key K. Not given: each time
// seed=S seeds the probabilities.
#ifndef CAGEFIT_SERVER_SESSION_FAIL_PLAN_H_
#define CAGEFIT_SERVER_SESSION_FAIL_PLAN_H_

#include <cstdint>
#include <mutex>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace cagefit::server {

struct FailAction {
  enum class Kind { kKill, kAbort, kError, kDelay } kind = Kind::kKill;
  absl::StatusCode code = absl::StatusCode::kUnavailable;  // of kError
  int64_t delay_ms = 0;                                    // of kDelay
};

// Thread-safe once parsed.
class FailPlan {
 public:
  // INVALID_ARGUMENT naming the entry.
  absl::Status Parse(absl::string_view text);

  // Counts that the point is passed; what is to happen, in the order of the entries.
  std::vector<FailAction> Hit(absl::string_view point, uint64_t key);

 private:
  struct Entry {
    std::string point;
    FailAction action;
    std::optional<uint64_t> nth, key;
    std::optional<double> probability;
    uint64_t hits = 0;
  };
  static absl::Status ParseAction(absl::string_view text, FailAction* action);
  static absl::Status ParseWhen(absl::string_view text, Entry* entry);

  std::mutex mutex_;
  std::vector<Entry> entries_;
  std::mt19937_64 random_;
};

}  // namespace cagefit::server

#endif  // CAGEFIT_SERVER_SESSION_FAIL_PLAN_H_
