// What a client saw as a line of text, so that it outlives the client.
#ifndef CAGEFIT_TESTS_SOAK_EVENT_LINE_H_
#define CAGEFIT_TESTS_SOAK_EVENT_LINE_H_

#include <optional>
#include <string>

#include "tests/support/history_checker.h"

namespace cagefit::testing {

std::string LineOf(const History::Event& event);  // without its end

// Nothing for a line that was cut off.
std::optional<History::Event> EventOf(const std::string& line);

}  // namespace cagefit::testing

#endif  // CAGEFIT_TESTS_SOAK_EVENT_LINE_H_
