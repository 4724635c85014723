// What a server lets its clients in by: TLS and tokens.
#ifndef CAGEFIT_SERVER_SERVER_ACCESS_H_
#define CAGEFIT_SERVER_SERVER_ACCESS_H_

#include <spdlog/logger.h>

#include <memory>

#include "absl/status/statusor.h"
#include "server/server_options.h"
#include "server/session/token_file.h"
#include "server/transport/tls_credentials.h"

namespace cagefit::server {

// Must outlive the server. Files that change are read again; the log says so.
struct ServerAccess {
  // INVALID_ARGUMENT or FAILED_PRECONDITION, naming file, and line where there are some.
  static absl::StatusOr<ServerAccess> Open(const ServerOptions& options,
                                           std::shared_ptr<spdlog::logger> log);

  // Of one address that the server listens on. Unix sockets are plain: their folder guards them.
  std::shared_ptr<grpc::ServerCredentials> CredentialsFor(const std::string& address) const;

  std::unique_ptr<TokenFile> tokens;    // null: nobody needs one
  std::unique_ptr<TlsFiles> tls_files;  // null: no TLS
  std::shared_ptr<TlsCredentials> tls;
};

}  // namespace cagefit::server

#endif  // CAGEFIT_SERVER_SERVER_ACCESS_H_
