// Judges what an application saw of one session while clients, servers and networks failed.
//
//   The promise: each frame is answered once, in order, with the bits of an undisturbed run, and
//   what was answered is never lost again.
#ifndef CAGEFIT_TESTS_SUPPORT_HISTORY_CHECKER_H_
#define CAGEFIT_TESTS_SUPPORT_HISTORY_CHECKER_H_

#include <cstdint>
#include <string>
#include <vector>

#include "core/base/types.h"

namespace cagefit::testing {

// The state after a frame, to the bit.
std::string BitsOf(const Points3d& control_vertices);

// In the order in which the application saw things. One thread at a time.
class History {
 public:
  struct Event {
    enum class Kind { kOpened, kSent, kAnswered } kind = Kind::kOpened;
    uint64_t number = 0;  // of the frame; when opened: the next one, as the server says
    uint64_t epoch = 0;   // when opened
    std::string bits;     // when answered: the state afterwards
  };

  void Add(const Event& event) { events_.push_back(event); }
  void Opened(uint64_t next_sequence_number, uint64_t epoch);
  void Sent(uint64_t number);  // for the first time or again
  void Answered(uint64_t number, std::string bits);

  const std::vector<Event>& events() const { return events_; }

 private:
  std::vector<Event> events_;
};

// A sentence for each broken promise; empty when the history is as promised. `undisturbed` holds
// the bits after each frame that was to be answered, by number.
std::vector<std::string> CheckHistory(const History& history,
                                      const std::vector<std::string>& undisturbed);

}  // namespace cagefit::testing

#endif  // CAGEFIT_TESTS_SUPPORT_HISTORY_CHECKER_H_
