// What goes wrong with one connection.
#ifndef CAGEFIT_TESTS_SUPPORT_FAULT_PLAN_H_
#define CAGEFIT_TESTS_SUPPORT_FAULT_PLAN_H_

#include <chrono>
#include <cstdint>
#include <optional>
#include <random>
#include <string>

namespace cagefit::testing {

enum class Fault {
  kNone,
  kDelay,     // each block of bytes is passed on `time` after it came
  kHold,      // nothing is passed on for `time`, then everything
  kReset,     // both sides see the connection reset
  kTruncate,  // the receiver sees the end, the sender a reset
  kTrickle,   // `trickle_bytes` are passed on each `time`
  kHalfOpen,  // bytes disappear and the connection stays; after `time`, if not 0, it is reset
};
inline constexpr Fault kFaults[] = {Fault::kDelay,    Fault::kHold,    Fault::kReset,
                                    Fault::kTruncate, Fault::kTrickle, Fault::kHalfOpen};

enum class Direction { kToServer, kToClient };

struct FaultPlan {
  Fault fault = Fault::kNone;
  Direction direction = Direction::kToServer;
  int64_t after_bytes = 0;  // of that direction are passed on unharmed
  std::chrono::milliseconds time{0};
  int64_t trickle_bytes = 1;
};

inline const char* NameOf(Fault fault) {
  constexpr const char* kNames[] = {"none",     "delay",   "hold",     "reset",
                                    "truncate", "trickle", "half-open"};
  return kNames[static_cast<int>(fault)];
}

inline std::optional<Fault> FaultNamed(const std::string& name) {
  for (const Fault fault : kFaults) {
    if (name == NameOf(fault)) return fault;
  }
  return std::nullopt;
}

// A plan with this fault: direction, moment and times follow from seed and number of the
// connection.
inline FaultPlan RandomPlan(Fault fault, uint64_t seed, uint64_t connection,
                            int64_t most_bytes = 60'000) {
  std::seed_seq sequence{seed, connection, static_cast<uint64_t>(fault)};
  std::mt19937_64 random(sequence);
  FaultPlan plan;
  plan.fault = fault;
  plan.direction = random() % 2 == 0 ? Direction::kToServer : Direction::kToClient;
  plan.after_bytes = static_cast<int64_t>(random() % static_cast<uint64_t>(most_bytes));
  plan.time = std::chrono::milliseconds(fault == Fault::kTrickle ? 1 : 1 + random() % 200);
  plan.trickle_bytes = static_cast<int64_t>(1 + random() % 400);
  return plan;
}

}  // namespace cagefit::testing

#endif  // CAGEFIT_TESTS_SUPPORT_FAULT_PLAN_H_
