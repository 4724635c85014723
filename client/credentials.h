// How a client shows who it is, and whom it takes for its server.
#ifndef CAGEFIT_CLIENT_CREDENTIALS_H_
#define CAGEFIT_CLIENT_CREDENTIALS_H_

#include <string>

#include "absl/status/status.h"

namespace cagefit::client {

// Files are PEM, but for the token's, which holds the token alone. Unix sockets are always plain.
struct ClientCredentials {
  bool tls = false;                 // set or not, a ca_file or cert_file asks for TLS, too
  std::string ca_file;              // of authorities that the server may have its certificate from;
                                    // empty: those that the system trusts
  std::string cert_file, key_file;  // the client's own, both or neither
  std::string token_file;           // empty: no token
  bool plain_token = false;         // the token may go to another machine without TLS

  bool wants_tls() const { return tls || !ca_file.empty() || !cert_file.empty(); }

  // INVALID_ARGUMENT for a certificate without its key or the reverse, and for a token that would
  // go to another machine, as `address` has it, for all to read.
  absl::Status Check(const std::string& address) const;
};

// A Unix socket or a loopback address: what goes there, nobody on the network sees.
bool StaysOnThisMachine(const std::string& address);

}  // namespace cagefit::client

#endif  // CAGEFIT_CLIENT_CREDENTIALS_H_
