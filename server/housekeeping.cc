#include "server/housekeeping.h"

#include <algorithm>
#include <string>
#include <utility>

#include "absl/time/clock.h"

namespace cagefit::server {
namespace {

constexpr absl::Duration kLongestExpiryInterval = absl::Minutes(1);

}  // namespace

Housekeeping::Housekeeping(const Options& options, Journal* journal, SessionStore* store,
                           StoreFn store_seen, std::shared_ptr<spdlog::logger> log)
    : options_(options),
      journal_(journal),
      store_(store),
      store_seen_(std::move(store_seen)),
      log_(std::move(log)) {
  LookAtJournal();  // so that readiness is true from the start
  thread_ = std::thread([this] { Work(); });
}

Housekeeping::~Housekeeping() {
  {
    std::lock_guard<std::mutex> lock(mutex_);
    ending_ = true;
  }
  wake_.notify_all();
  thread_.join();
}

void Housekeeping::Work() {
  std::unique_lock<std::mutex> lock(mutex_);
  while (!wake_.wait_for(lock, absl::ToChronoMilliseconds(options_.interval),
                         [this] { return ending_; })) {
    lock.unlock();
    LookAtJournal();
    const absl::Time now = absl::Now();
    store_->Unload(now - options_.unload_after);
    if (journal_status_.ok()) Expire(now);
    lock.lock();
  }
}

void Housekeeping::LookAtJournal() {
  const absl::Status status = journal_->Probe();
  if (status.ok() && !journal_status_.ok()) log_->info("store back");
  if (!status.ok() && journal_status_.ok()) {
    log_->error("store away error=\"{}\"", std::string(status.message()));
  }
  journal_status_ = status;
  store_seen_(status);
}

void Housekeeping::Expire(absl::Time now) {
  // Sessions with a stream are marked as used more often than they could expire.
  const absl::Duration interval = std::min(options_.time_to_live / 4, kLongestExpiryInterval);
  if (now < last_expiry_ + interval) return;
  last_expiry_ = now;
  const absl::StatusOr<int> expired = store_->Expire(now - options_.time_to_live);
  if (expired.ok() && *expired > 0) log_->info("sessions expired count={}", *expired);
}

}  // namespace cagefit::server
