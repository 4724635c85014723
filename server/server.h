// The whole service in one object: sessions, pools and network.
#ifndef CAGEFIT_SERVER_SERVER_H_
#define CAGEFIT_SERVER_SERVER_H_

#include <spdlog/logger.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "server/server_options.h"

namespace cagefit::server {

class Server {
 public:
  // Serves when it returns. INVALID_ARGUMENT for bad options, UNAVAILABLE naming the address that
  // cannot be listened on.
  static absl::StatusOr<std::unique_ptr<Server>> Start(const ServerOptions& options,
                                                       std::shared_ptr<spdlog::logger> log);
  // As Shutdown without time to drain.
  ~Server();

  // As given, with the ports that were bound.
  const std::vector<std::string>& addresses() const;

  // Of health alone; empty unless ServerOptions::health_listen is set.
  const std::vector<std::string>& health_addresses() const;

  // HOST:PORT of the metrics, where ServerOptions::metrics_listen asks for them.
  std::optional<std::string> metrics_address() const;

  // Health says not ready from now on, and all else goes on: load balancers look elsewhere before
  // anything ends.
  void StopBeingReady();

  // As StopBeingReady; then streams answer the frames in work and end with UNAVAILABLE, and
  // what is left after `drain` is cancelled. Returns when nothing runs any more.
  void Shutdown(absl::Duration drain);

 private:
  struct Parts;
  explicit Server(std::unique_ptr<Parts> parts);
  std::unique_ptr<Parts> parts_;
};

}  // namespace cagefit::server

#endif  // CAGEFIT_SERVER_SERVER_H_
