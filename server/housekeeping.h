// What a server does by itself now and then: looks after its journal, and after sessions that
// nobody uses.
#ifndef CAGEFIT_SERVER_HOUSEKEEPING_H_
#define CAGEFIT_SERVER_HOUSEKEEPING_H_

#include <spdlog/logger.h>

#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <thread>

#include "absl/status/status.h"
#include "absl/time/time.h"
#include "server/session/journal.h"
#include "server/session/session_store.h"

namespace cagefit::server {

class Housekeeping {
 public:
  struct Options {
    absl::Duration interval = absl::Seconds(1);  // between looks at the journal
    // Sessions unused for so long leave the memory of a server whose journal is durable.
    absl::Duration unload_after = absl::Minutes(1);
    absl::Duration time_to_live = absl::InfiniteDuration();  // of unused sessions
  };
  // Told whether the journal can be written, after each look.
  using StoreFn = std::function<void(const absl::Status&)>;

  // Begins at once. Journal and store must outlive this object.
  Housekeeping(const Options& options, Journal* journal, SessionStore* store, StoreFn store_seen,
               std::shared_ptr<spdlog::logger> log);
  ~Housekeeping();
  Housekeeping(const Housekeeping&) = delete;
  Housekeeping& operator=(const Housekeeping&) = delete;

 private:
  void Work();
  void LookAtJournal();
  void Expire(absl::Time now);

  const Options options_;
  Journal* const journal_;
  SessionStore* const store_;
  const StoreFn store_seen_;
  const std::shared_ptr<spdlog::logger> log_;
  absl::Status journal_status_;  // at the last look
  absl::Time last_expiry_ = absl::InfinitePast();

  std::mutex mutex_;
  std::condition_variable wake_;
  bool ending_ = false;
  std::thread thread_;
};

}  // namespace cagefit::server

#endif  // CAGEFIT_SERVER_HOUSEKEEPING_H_
