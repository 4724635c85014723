#include "server/session/fail_point.h"

#include <signal.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <iostream>
#include <thread>

#include "absl/strings/str_cat.h"
#include "server/session/fail_plan.h"

namespace cagefit::server {
namespace {

constexpr char kVariable[] = "CAGEFITD_FAIL_POINTS";

FailPlan* PlanOfEnvironment() {
  auto* plan = new FailPlan;
  const char* text = std::getenv(kVariable);
  if (text == nullptr) return plan;
  const absl::Status parsed = plan->Parse(text);
  if (!parsed.ok()) {
    std::cerr << kVariable << ": " << parsed.message() << "\n";
    std::_Exit(2);
  }
  unsetenv(kVariable);  // the server's options know no such variable
  return plan;
}

// Before main, so that a bad plan is seen at once.
FailPlan* const plan = PlanOfEnvironment();

}  // namespace

absl::Status HitFailPoint(absl::string_view name, uint64_t key) {
  for (const FailAction& action : plan->Hit(name, key)) {
    switch (action.kind) {
      case FailAction::Kind::kKill:
        kill(getpid(), SIGKILL);
        pause();
        break;
      case FailAction::Kind::kAbort:
        std::abort();
      case FailAction::Kind::kError:
        return absl::Status(action.code, absl::StrCat("fail point ", name));
      case FailAction::Kind::kDelay:
        std::this_thread::sleep_for(std::chrono::milliseconds(action.delay_ms));
        break;
    }
  }
  return absl::OkStatus();
}

}  // namespace cagefit::server
