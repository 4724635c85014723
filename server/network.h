// Services on the network: what bounds and protects every connection.
#ifndef CAGEFIT_SERVER_NETWORK_H_
#define CAGEFIT_SERVER_NETWORK_H_

#include <grpcpp/grpcpp.h>

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/time/time.h"

namespace cagefit::server {

struct Network {
  std::unique_ptr<grpc::Server> server;  // null: none
  std::vector<std::string> addresses;    // as asked for, with the ports that were bound

  // Takes no new calls, cancels what is left after `drain`, and returns when no call is left.
  void End(absl::Duration drain) const;
};

struct Listener {
  std::string address;  // HOST:PORT or unix:PATH
  std::shared_ptr<grpc::ServerCredentials> credentials;
};

enum class Reflection { kOff, kOn };

// Connections hold about `quota_bytes` together, the last line against floods of headers; admission
// is by the limits of the options. Serves when it returns; `services` must outlive the server.
// UNAVAILABLE naming the address that cannot be listened on.
absl::StatusOr<Network> Serve(const std::vector<Listener>& listeners,
                              const std::vector<grpc::Service*>& services, Reflection reflection,
                              int64_t quota_bytes);

}  // namespace cagefit::server

#endif  // CAGEFIT_SERVER_NETWORK_H_
