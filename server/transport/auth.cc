#include "server/transport/auth.h"

#include <grpc/grpc_security_constants.h>
#include <grpcpp/security/auth_context.h>

#include <string>
#include <utility>
#include <vector>

#include "absl/strings/match.h"
#include "absl/strings/string_view.h"
#include "absl/time/clock.h"
#include "server/session/error_detail.h"

namespace cagefit::server {
namespace {

constexpr char kAuthorization[] = "authorization";
constexpr absl::string_view kBearer = "Bearer ";

absl::string_view View(grpc::string_ref text) { return {text.data(), text.size()}; }

// The call's token; empty when it has none, or several, of which none is to be preferred.
absl::string_view TokenOf(const grpc::CallbackServerContext& context) {
  const auto found = context.client_metadata().equal_range(kAuthorization);
  if (found.first == found.second || std::next(found.first) != found.second) return {};
  const absl::string_view value = View(found.first->second);
  // The scheme's name is without case (RFC 9110).
  if (!absl::StartsWithIgnoreCase(value, kBearer)) return {};
  return value.substr(kBearer.size());
}

// Null when the peer has a certificate that names nobody.
std::shared_ptr<const Principal> PrincipalOfPeer(const grpc::CallbackServerContext& context) {
  auto principal = std::make_shared<Principal>();
  const std::shared_ptr<const grpc::AuthContext> peer = context.auth_context();
  if (peer == nullptr || !peer->IsPeerAuthenticated()) return principal;
  for (const char* property : {GRPC_X509_CN_PROPERTY_NAME, GRPC_X509_SAN_PROPERTY_NAME}) {
    const std::vector<grpc::string_ref> names = peer->FindPropertyValues(property);
    if (names.empty() || names.front().empty()) continue;
    principal->name = std::string(View(names.front()));
    return principal;
  }
  return nullptr;
}

}  // namespace

absl::StatusOr<PrincipalSessions> Auth::Enter(const grpc::CallbackServerContext& context) const {
  std::shared_ptr<const Principal> principal =
      tokens_ == nullptr ? PrincipalOfPeer(context) : tokens_->Find(TokenOf(context), absl::Now());
  if (principal == nullptr) {
    return WithDetail(absl::UnauthenticatedError("this server wants a valid token or certificate"),
                      {"NO_VALID_CREDENTIALS", "", "", ""});
  }
  return PrincipalSessions(store_, std::move(principal));
}

}  // namespace cagefit::server
