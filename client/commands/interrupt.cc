#include "client/commands/interrupt.h"

#include <semaphore.h>

#include <cstdlib>
#include <utility>

#include "client/commands/command.h"

namespace cagefit::client {
namespace {

// Threads that libraries start before main would take a signal that is only blocked here, and die
// of it: so there is a handler, which any thread may run.
sem_t signals_seen;

void OnSignal(int) { sem_post(&signals_seen); }

}  // namespace

Interrupt::Interrupt() {
  sem_init(&signals_seen, 0, 0);
  struct sigaction action = {};
  action.sa_handler = OnSignal;
  action.sa_flags = SA_RESTART;
  sigaction(SIGINT, &action, &old_interrupt_);
  sigaction(SIGTERM, &action, &old_terminate_);
  thread_ = std::thread([this] { Wait(); });
}

Interrupt::~Interrupt() {
  ending_ = true;
  sem_post(&signals_seen);
  thread_.join();
  sigaction(SIGINT, &old_interrupt_, nullptr);
  sigaction(SIGTERM, &old_terminate_, nullptr);
}

void Interrupt::SetAction(std::function<void()> action) {
  std::lock_guard<std::mutex> lock(mutex_);
  action_ = std::move(action);
  if (seen_ && action_) action_();
}

void Interrupt::Wait() {
  while (true) {
    if (sem_wait(&signals_seen) != 0) continue;
    if (ending_) return;
    if (seen_.exchange(true)) std::_Exit(kFailed);
    std::lock_guard<std::mutex> lock(mutex_);
    if (action_) action_();
  }
}

}  // namespace cagefit::client
