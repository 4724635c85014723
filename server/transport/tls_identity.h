// A server's certificate and key, and whose certificates it takes from its clients, as PEM text.
#ifndef CAGEFIT_SERVER_TRANSPORT_TLS_IDENTITY_H_
#define CAGEFIT_SERVER_TRANSPORT_TLS_IDENTITY_H_

#include <string>
#include <vector>

#include "absl/status/statusor.h"

namespace cagefit::server {

struct TlsPaths {
  std::string certificates;  // the server's, then those between it and its root
  std::string key;
  std::string client_roots;  // empty: clients are asked for no certificate

  bool operator==(const TlsPaths& other) const {
    return certificates == other.certificates && key == other.key &&
           client_roots == other.client_roots;
  }
  std::vector<std::string> All() const;  // that are set, in this order
};

struct TlsIdentity {
  std::string certificates, key, client_roots;
};

// `contents`: of the files at `paths.All()`. INVALID_ARGUMENT naming the file that holds no
// certificate or no key (a key under a password counts as none), or a key that does not belong to
// the certificate; never with what is in a file.
absl::StatusOr<TlsIdentity> ParseTlsIdentity(const TlsPaths& paths,
                                             const std::vector<std::string>& contents);

}  // namespace cagefit::server

#endif  // CAGEFIT_SERVER_TRANSPORT_TLS_IDENTITY_H_
