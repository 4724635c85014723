#include "tests/support/history_checker.h"

#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"

namespace cagefit::testing {
namespace {

class Checker {
 public:
  explicit Checker(const std::vector<std::string>& undisturbed)
      : undisturbed_(undisturbed), answered_(undisturbed.size(), false) {}

  void Take(const History::Event& event) {
    switch (event.kind) {
      case History::Event::Kind::kOpened:
        return Opened(event);
      case History::Event::Kind::kSent:
        sent_ = std::max(sent_, event.number + 1);
        return;
      case History::Event::Kind::kAnswered:
        return Answered(event);
    }
  }

  std::vector<std::string> Finish() {
    for (size_t number = 0; number < answered_.size(); ++number) {
      if (!answered_[number]) Add("frame ", number, " is missing: it was never answered");
    }
    return std::move(broken_);
  }

 private:
  void Opened(const History::Event& event) {
    // The server may have stored answers that did not arrive, but not fewer than arrived.
    if (event.number < next_) {
      Add("frame ", next_ - 1, " was answered and is lost: the server goes on at ", event.number);
    }
    if (event.number > sent_) {
      Add("the server goes on at ", event.number, " but only ", sent_, " frames were sent");
    }
    if (event.epoch <= epoch_) Add("epoch ", event.epoch, " comes after epoch ", epoch_);
    epoch_ = std::max(epoch_, event.epoch);
  }

  void Answered(const History::Event& event) {
    const uint64_t number = event.number;
    if (number >= sent_) Add("frame ", number, " is answered but was not sent");
    if (number >= answered_.size()) {
      Add("frame ", number, " is answered; the sequence has ", answered_.size());
      return;
    }
    if (answered_[number]) {
      Add("frame ", number, " is answered twice");
    } else if (number < next_) {
      Add("frame ", number, " is answered out of order, after frame ", next_ - 1);
    }
    if (event.bits != undisturbed_[number]) {
      Add("frame ", number, " differs from the undisturbed run");
    }
    answered_[number] = true;
    next_ = std::max(next_, number + 1);
  }

  template <typename... Parts>
  void Add(const Parts&... parts) {
    broken_.push_back(absl::StrCat(parts...));
  }

  const std::vector<std::string>& undisturbed_;
  std::vector<bool> answered_;
  uint64_t next_ = 0;  // behind the latest answer
  uint64_t sent_ = 0;  // behind the latest frame sent
  uint64_t epoch_ = 0;
  std::vector<std::string> broken_;
};

}  // namespace

std::string BitsOf(const Points3d& control_vertices) {
  return std::string(reinterpret_cast<const char*>(control_vertices.data()),
                     control_vertices.size() * sizeof(double));
}

void History::Opened(uint64_t next_sequence_number, uint64_t epoch) {
  events_.push_back({Event::Kind::kOpened, next_sequence_number, epoch, ""});
}

void History::Sent(uint64_t number) { events_.push_back({Event::Kind::kSent, number, 0, ""}); }

void History::Answered(uint64_t number, std::string bits) {
  events_.push_back({Event::Kind::kAnswered, number, 0, std::move(bits)});
}

std::vector<std::string> CheckHistory(const History& history,
                                      const std::vector<std::string>& undisturbed) {
  Checker checker(undisturbed);
  for (const History::Event& event : history.events()) checker.Take(event);
  return checker.Finish();
}

}  // namespace cagefit::testing
