#include "server/transport/tls_credentials.h"

#include <grpc/grpc.h>
#include <grpc/grpc_security.h>
#include <netdb.h>
#include <sys/socket.h>

#include <vector>

#include "absl/strings/str_cat.h"

namespace cagefit::server {
namespace {

// The host of HOST:PORT or [HOST]:PORT, and its port.
std::pair<std::string, std::string> Split(const std::string& address) {
  const size_t colon = address.rfind(':');
  if (colon == std::string::npos) return {address, ""};
  std::string host = address.substr(0, colon);
  if (host.size() >= 2 && host.front() == '[' && host.back() == ']') {
    host = host.substr(1, host.size() - 2);
  }
  return {host, address.substr(colon + 1)};
}

std::vector<std::string> NumericHosts(const std::string& host) {
  addrinfo hints = {};
  hints.ai_socktype = SOCK_STREAM;
  hints.ai_flags = AI_PASSIVE;
  addrinfo* found = nullptr;
  if (getaddrinfo(host.c_str(), nullptr, &hints, &found) != 0) return {};
  std::vector<std::string> hosts;
  for (const addrinfo* a = found; a != nullptr; a = a->ai_next) {
    char name[NI_MAXHOST];
    if (getnameinfo(a->ai_addr, a->ai_addrlen, name, sizeof(name), nullptr, 0, NI_NUMERICHOST) ==
        0) {
      hosts.push_back(a->ai_family == AF_INET6 ? absl::StrCat("[", name, "]") : name);
    }
  }
  freeaddrinfo(found);
  return hosts;
}

}  // namespace

// A name such as localhost may stand for several addresses. gRPC would have all their sockets share
// one handshaker factory, which one of them replaces without a lock while another uses it (1.51.1,
// ssl_security_connector.cc): so each address gets credentials of its own.
int TlsCredentials::AddPortToServer(const std::string& address, grpc_server* server) {
  const auto [host, port] = Split(address);
  const std::vector<std::string> hosts = NumericHosts(host);
  if (hosts.size() < 2) return AddOne(address, server);
  int bound = 0;
  for (const std::string& numeric : hosts) {
    const int port_of_one =
        AddOne(absl::StrCat(numeric, ":", bound == 0 ? port : absl::StrCat(bound)), server);
    if (bound == 0) bound = port_of_one;  // a machine may lack IPv6: one address is enough
  }
  return bound;
}

int TlsCredentials::AddOne(const std::string& address, grpc_server* server) {
  ports_.push_back({files_, nullptr});
  grpc_server_credentials* credentials = grpc_ssl_server_credentials_create_with_options(
      grpc_ssl_server_credentials_create_options_using_config_fetcher(
          files_->wants_client_certificates()
              ? GRPC_SSL_REQUEST_AND_REQUIRE_CLIENT_CERTIFICATE_AND_VERIFY
              : GRPC_SSL_DONT_REQUEST_CLIENT_CERTIFICATE,
          &TlsCredentials::Fetch, &ports_.back()));
  const int port = grpc_server_add_http2_port(server, address.c_str(), credentials);
  grpc_server_credentials_release(credentials);
  return port;
}

// Called by one handshake of the port at a time.
grpc_ssl_certificate_config_reload_status TlsCredentials::Fetch(
    void* user_data, grpc_ssl_server_certificate_config** config) {
  Port* port = static_cast<Port*>(user_data);
  std::shared_ptr<const TlsIdentity> identity = port->files->identity();
  if (identity == port->identity) return GRPC_SSL_CERTIFICATE_CONFIG_RELOAD_UNCHANGED;
  const grpc_ssl_pem_key_cert_pair pair = {identity->key.c_str(), identity->certificates.c_str()};
  // gRPC aborts without roots (1.51.1). Where clients are not asked for a certificate, they are not
  // looked at.
  const std::string& roots =
      identity->client_roots.empty() ? identity->certificates : identity->client_roots;
  *config = grpc_ssl_server_certificate_config_create(roots.c_str(), &pair, 1);
  port->identity = std::move(identity);
  return GRPC_SSL_CERTIFICATE_CONFIG_RELOAD_NEW;
}

}  // namespace cagefit::server
