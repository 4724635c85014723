#include "server/server_access.h"

#include <utility>

#include "absl/strings/escaping.h"
#include "absl/strings/match.h"
#include "core/base/status.h"

namespace cagefit::server {
namespace {

constexpr absl::Duration kPoll = absl::Milliseconds(500);

}  // namespace

absl::StatusOr<ServerAccess> ServerAccess::Open(const ServerOptions& options,
                                                std::shared_ptr<spdlog::logger> log) {
  ServerAccess access;
  if (!options.tokens.empty()) {
    ASSIGN_OR_RETURN(
        access.tokens,
        TokenFile::Open(options.tokens, kPoll, [log](const absl::Status& status, size_t tokens) {
          if (status.ok()) return log->info("tokens reloaded count={}", tokens);
          log->error("tokens not reloaded, the old ones stay in force error=\"{}\"",
                     absl::CEscape(status.message()));
        }));
  }
  if (!options.tls_cert.empty()) {
    ASSIGN_OR_RETURN(
        access.tls_files,
        TlsFiles::Open({options.tls_cert, options.tls_key, options.tls_client_ca}, kPoll,
                       [log](const absl::Status& status) {
                         if (status.ok()) return log->info("certificate reloaded");
                         log->error(
                             "certificate not reloaded, the old one stays in force error=\"{}\"",
                             absl::CEscape(status.message()));
                       }));
    access.tls = std::make_shared<TlsCredentials>(access.tls_files.get());
  }
  return access;
}

std::shared_ptr<grpc::ServerCredentials> ServerAccess::CredentialsFor(
    const std::string& address) const {
  if (tls == nullptr || absl::StartsWith(address, "unix:"))
    return grpc::InsecureServerCredentials();
  return tls;
}

}  // namespace cagefit::server
