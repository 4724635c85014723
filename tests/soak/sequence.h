// The sequence that soak programs stream: small, so that a frame takes some milliseconds.
#ifndef CAGEFIT_TESTS_SOAK_SEQUENCE_H_
#define CAGEFIT_TESTS_SOAK_SEQUENCE_H_

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "client/fit_client.h"

namespace cagefit::testing {

v1::CreateSessionRequest SoakSession();
client::OutgoingFrame SoakFrame(uint64_t number);

// The bits after each of the first `frames` frames where nothing fails: from a server of this
// process and one stream.
absl::StatusOr<std::vector<std::string>> UndisturbedBits(uint64_t frames);

}  // namespace cagefit::testing

#endif  // CAGEFIT_TESTS_SOAK_SEQUENCE_H_
