// The server inside this process: one code path for local and remote fits.
#ifndef CAGEFIT_CLIENT_EMBEDDED_SERVER_H_
#define CAGEFIT_CLIENT_EMBEDDED_SERVER_H_

#include <memory>
#include <string>

#include "absl/status/statusor.h"

namespace cagefit::client {

class EmbeddedServer {
 public:
  // Serves on a Unix socket that only this user can reach. Templates are made by this program
  // itself ("/proc/self/exe template ..."). `threads` (0: one per core) and `store` as in
  // ServerOptions.
  static absl::StatusOr<std::unique_ptr<EmbeddedServer>> Start(int threads = 0,
                                                               const std::string& store = "memory");
  // Cancels what is left and removes the socket.
  ~EmbeddedServer();

  const std::string& address() const;  // for ClientOptions

 private:
  struct Parts;
  explicit EmbeddedServer(std::unique_ptr<Parts> parts);
  std::unique_ptr<Parts> parts_;
};

}  // namespace cagefit::client

#endif  // CAGEFIT_CLIENT_EMBEDDED_SERVER_H_
