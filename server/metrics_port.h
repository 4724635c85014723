// Metrics for Prometheus, over HTTP at /metrics on a port of their own.
#ifndef CAGEFIT_SERVER_METRICS_PORT_H_
#define CAGEFIT_SERVER_METRICS_PORT_H_

#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "server/http_port.h"
#include "server/session/readiness.h"
#include "server/transport/service_state.h"

namespace cagefit::server {

// `sessions` counts those of the store. Everything is read anew for each scrape; what `state`
// points to and `readiness` must outlive the port. Errors as of HttpPort::Open.
absl::StatusOr<std::unique_ptr<HttpPort>> OpenMetricsPort(const std::string& address,
                                                          const ServiceState& state,
                                                          const Readiness& readiness,
                                                          std::function<int64_t()> sessions);

}  // namespace cagefit::server

#endif  // CAGEFIT_SERVER_METRICS_PORT_H_
