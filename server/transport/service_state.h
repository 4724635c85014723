// What all calls of a server share.
#ifndef CAGEFIT_SERVER_TRANSPORT_SERVICE_STATE_H_
#define CAGEFIT_SERVER_TRANSPORT_SERVICE_STATE_H_

#include <spdlog/logger.h>

#include <memory>

#include "server/session/memory_account.h"
#include "server/session/metrics.h"
#include "server/session/scheduler.h"
#include "server/transport/auth.h"
#include "server/transport/stream_registry.h"

namespace cagefit::server {

// Not owned, but for the logger; all of it outlives every call.
struct ServiceState {
  const Auth* auth = nullptr;  // every call enters by it
  Scheduler* scheduler = nullptr;
  MemoryAccount* budget = nullptr;
  StreamRegistry* streams = nullptr;
  ClockFn clock;  // milliseconds
  std::shared_ptr<spdlog::logger> log;
  Metrics* metrics = nullptr;
};

}  // namespace cagefit::server

#endif  // CAGEFIT_SERVER_TRANSPORT_SERVICE_STATE_H_
