#include "server/session/fail_plan.h"

#include <array>
#include <utility>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "absl/strings/strip.h"
#include "core/base/status.h"

namespace cagefit::server {
namespace {

using Parts = std::pair<absl::string_view, absl::string_view>;

// Text before and behind the first `separator`; the second part is empty without one.
Parts Cut(absl::string_view text, char separator) {
  return absl::StrSplit(text, absl::MaxSplits(separator, 1));
}

std::optional<absl::StatusCode> CodeNamed(absl::string_view name) {
  for (int code = 1; code <= 16; ++code) {
    const auto candidate = static_cast<absl::StatusCode>(code);
    if (absl::StatusCodeToString(candidate) == name) return candidate;
  }
  return std::nullopt;
}

absl::Status Bad(absl::string_view what, absl::string_view value, absl::string_view expected) {
  return absl::InvalidArgumentError(absl::StrCat(what, " is \"", value, "\"; ", expected));
}

}  // namespace

absl::Status FailPlan::ParseAction(absl::string_view text, FailAction* action) {
  const auto [name, argument] = Cut(text, ':');
  if (name == "error") {
    const std::optional<absl::StatusCode> code = CodeNamed(argument);
    if (!code.has_value()) return Bad("code", argument, "expected one as in UNAVAILABLE");
    *action = {FailAction::Kind::kError, *code, 0};
    return absl::OkStatus();
  }
  if (name == "delay") {
    action->kind = FailAction::Kind::kDelay;
    if (absl::SimpleAtoi(argument, &action->delay_ms) && action->delay_ms >= 0) {
      return absl::OkStatus();
    }
    return Bad("delay", argument, "expected milliseconds");
  }
  if (text == "kill" || text == "abort") {
    action->kind = text == "kill" ? FailAction::Kind::kKill : FailAction::Kind::kAbort;
    return absl::OkStatus();
  }
  return Bad("action", text, "expected kill, abort, error:CODE or delay:MILLISECONDS");
}

absl::Status FailPlan::ParseWhen(absl::string_view text, Entry* entry) {
  absl::string_view value = text;
  if (absl::ConsumePrefix(&value, "p")) {
    double probability = 0;
    if (!absl::SimpleAtod(value, &probability) || !(probability >= 0 && probability <= 1)) {
      return Bad("probability", value, "expected 0 to 1");
    }
    entry->probability = probability;
    return absl::OkStatus();
  }
  std::optional<uint64_t>& number = absl::ConsumePrefix(&value, "#") ? entry->key : entry->nth;
  uint64_t parsed = 0;
  if (!absl::SimpleAtoi(value, &parsed)) return Bad("time", text, "expected N, pX or #K");
  number = parsed;
  return absl::OkStatus();
}

absl::Status FailPlan::Parse(absl::string_view text) {
  for (const absl::string_view part : absl::StrSplit(text, ',', absl::SkipEmpty())) {
    const auto [point, what] = Cut(part, '=');
    if (point == "seed") {
      uint64_t seed = 0;
      if (!absl::SimpleAtoi(what, &seed)) return Bad(part, what, "expected a number");
      random_.seed(seed);
      continue;
    }
    Entry entry;
    entry.point = std::string(point);
    const auto [action, when] = Cut(what, '@');
    absl::Status status = ParseAction(action, &entry.action);
    const bool has_when = action.size() < what.size();
    if (status.ok() && has_when) status = ParseWhen(when, &entry);
    if (!status.ok()) {
      return absl::InvalidArgumentError(absl::StrCat("fail point ", part, ": ", status.message()));
    }
    entries_.push_back(std::move(entry));
  }
  return absl::OkStatus();
}

std::vector<FailAction> FailPlan::Hit(absl::string_view point, uint64_t key) {
  std::vector<FailAction> actions;
  std::lock_guard<std::mutex> lock(mutex_);
  for (Entry& entry : entries_) {
    if (entry.point != point) continue;
    ++entry.hits;
    if (entry.nth.has_value() && *entry.nth != entry.hits) continue;
    if (entry.key.has_value() && *entry.key != key) continue;
    if (entry.probability.has_value() &&
        std::uniform_real_distribution<double>()(random_) >= *entry.probability) {
      continue;
    }
    actions.push_back(entry.action);
  }
  return actions;
}

}  // namespace cagefit::server
