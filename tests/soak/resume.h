// A client that goes on after every failure.
#ifndef CAGEFIT_TESTS_SOAK_RESUME_H_
#define CAGEFIT_TESTS_SOAK_RESUME_H_

#include <cstdint>
#include <functional>
#include <string>

#include "absl/status/status.h"
#include "absl/time/time.h"
#include "tests/support/history_checker.h"

namespace cagefit::testing {

struct Resumption {
  std::string address;
  std::string session_id;
  uint64_t first = 0;   // the first frame without an answer
  uint64_t frames = 0;  // of the sequence
  // Without an answer for so long, it gives up.
  absl::Duration patience = absl::Seconds(60);
  // Called with each event, in order; one call at a time.
  std::function<void(const History::Event&)> seen;
};

// Streams SoakFrame(first) to SoakFrame(frames - 1) and returns once all are answered; opens stream
// after stream as often as one breaks. An error says why it gave up.
absl::Status StreamToEnd(const Resumption& resumption);

}  // namespace cagefit::testing

#endif  // CAGEFIT_TESTS_SOAK_RESUME_H_
