// grpc.health.v1.Health. Service "" is the process: SERVING for as long as it answers, since
// starting it anew would mend nothing else. Service "cagefit.v1.Fitting" is SERVING while the
// server is ready for work: not while it drains or its store is away.
//
// gRPC's own default service would do, but its watches hold up a server's shutdown until the
// deadline.
#ifndef CAGEFIT_SERVER_TRANSPORT_HEALTH_SERVICE_H_
#define CAGEFIT_SERVER_TRANSPORT_HEALTH_SERVICE_H_

#include <cstddef>
#include <mutex>
#include <set>
#include <string>

#include "grpc/health/v1/health.grpc.pb.h"
#include "server/session/readiness.h"

namespace cagefit::server {

// Thread-safe. Reactions only read a flag.
class HealthService final : public grpc::health::v1::Health::CallbackService {
 public:
  static constexpr size_t kMaxWatches = 1000;

  // `readiness` must not change any more when the service is destroyed.
  explicit HealthService(Readiness* readiness);

  grpc::ServerUnaryReactor* Check(grpc::CallbackServerContext* context,
                                  const grpc::health::v1::HealthCheckRequest* request,
                                  grpc::health::v1::HealthCheckResponse* response) override;
  grpc::ServerWriteReactor<grpc::health::v1::HealthCheckResponse>* Watch(
      grpc::CallbackServerContext* context,
      const grpc::health::v1::HealthCheckRequest* request) override;

  // Watches tell the status that they have not told yet, and end, now and from now on.
  void EndWatches();

 private:
  class Watcher;
  using Status = grpc::health::v1::HealthCheckResponse::ServingStatus;

  Status StatusOf(const std::string& service) const;

  const Readiness* const readiness_;
  std::mutex mutex_;  // also of what the watchers hold
  bool ended_ = false;
  std::set<Watcher*> watchers_;
};

}  // namespace cagefit::server

#endif  // CAGEFIT_SERVER_TRANSPORT_HEALTH_SERVICE_H_
