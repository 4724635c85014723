#include "client/credentials.h"

#include <arpa/inet.h>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"

namespace cagefit::client {
namespace {

bool IsUnix(const std::string& address) {
  return absl::StartsWith(address, "unix:") || absl::StartsWith(address, "unix-abstract:");
}

}  // namespace

bool StaysOnThisMachine(const std::string& address) {
  if (IsUnix(address)) return true;
  const size_t colon = address.rfind(':');
  const std::string host = address.substr(0, colon);
  if (host == "localhost" || host == "[::1]") return true;
  // All of 127.0.0.0/8; a name such as 127.example.com is no address.
  in_addr parsed;
  return inet_pton(AF_INET, host.c_str(), &parsed) == 1 && (ntohl(parsed.s_addr) >> 24) == 127;
}

absl::Status ClientCredentials::Check(const std::string& address) const {
  if (cert_file.empty() != key_file.empty()) {
    return absl::InvalidArgumentError(
        key_file.empty() ? "a client certificate is given without its key (--tls-key)"
                         : "a client key is given without its certificate (--tls-cert)");
  }
  if (token_file.empty() || plain_token || wants_tls() || StaysOnThisMachine(address)) {
    return absl::OkStatus();
  }
  return absl::InvalidArgumentError(
      absl::StrCat("the token would go to ", address,
                   " for all to read; expected --tls or --tls-ca FILE (or --plain-token, where the "
                   "network keeps secrets)"));
}

}  // namespace cagefit::client
