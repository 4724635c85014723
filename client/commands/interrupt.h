// Ctrl-C and SIGTERM as an event instead of an end.
#ifndef CAGEFIT_CLIENT_COMMANDS_INTERRUPT_H_
#define CAGEFIT_CLIENT_COMMANDS_INTERRUPT_H_

#include <atomic>
#include <functional>
#include <mutex>
#include <thread>

namespace cagefit::client {

// Make it before any thread that the program starts: those inherit that the signals are blocked.
// A second signal ends the program at once.
class Interrupt {
 public:
  Interrupt();
  ~Interrupt();
  Interrupt(const Interrupt&) = delete;
  Interrupt& operator=(const Interrupt&) = delete;

  // Called, from a thread of its own, when a signal arrives; at once if one has. Empty: nothing.
  void SetAction(std::function<void()> action);
  bool seen() const { return seen_; }

 private:
  void Wait();

  std::atomic<bool> seen_{false}, ending_{false};
  std::mutex mutex_;
  std::function<void()> action_;
  std::thread thread_;
};

}  // namespace cagefit::client

#endif  // CAGEFIT_CLIENT_COMMANDS_INTERRUPT_H_
