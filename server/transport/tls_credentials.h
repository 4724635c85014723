// TLS for a server's ports, with the files that are in force when a connection comes.
//
// Not by gRPC's own FileWatcherCertificateProvider, tried in 1.51.1: its server throws the old
// certificate away before it tries the new one, so a key that does not match, if only between two
// writes, leaves a port that refuses everybody, and an empty key file aborts the process. Here,
// every handshake asks for what is in force, and nothing gets there unchecked.
#ifndef CAGEFIT_SERVER_TRANSPORT_TLS_CREDENTIALS_H_
#define CAGEFIT_SERVER_TRANSPORT_TLS_CREDENTIALS_H_

#include <grpcpp/security/server_credentials.h>

#include <deque>
#include <memory>
#include <string>

#include "server/transport/tls_files.h"

namespace cagefit::server {

// TLS 1.2 and 1.3. Where the files name roots for clients, a client without a certificate of theirs
// gets no connection. Must outlive the server that listens with it, as `files` must.
class TlsCredentials final : public grpc::ServerCredentials {
 public:
  explicit TlsCredentials(const TlsFiles* files) : files_(files) {}

  void SetAuthMetadataProcessor(const std::shared_ptr<grpc::AuthMetadataProcessor>&) override {}

 private:
  // What one port has seen.
  struct Port {
    const TlsFiles* files;
    std::shared_ptr<const TlsIdentity> identity;
  };

  int AddPortToServer(const std::string& address, grpc_server* server) override;
  int AddOne(const std::string& address, grpc_server* server);
  static grpc_ssl_certificate_config_reload_status Fetch(
      void* port, grpc_ssl_server_certificate_config** config);

  const TlsFiles* const files_;
  std::deque<Port> ports_;  // their addresses stay
};

}  // namespace cagefit::server

#endif  // CAGEFIT_SERVER_TRANSPORT_TLS_CREDENTIALS_H_
