// The tokens that a server takes: a text of one line each,
//
//   NAME SHA-256-OF-THE-TOKEN [sessions=N] [bytes-per-second=N] [fits=N] [expires=TIME]   # comment
//
// NAME is the principal's: 1 to 64 letters, digits, dots, dashes and underscores. A name may have
// several tokens, so that a new one can be given out before the old one goes; their quotas must be
// the same. TIME is as in RFC 3339.
//
// A token has 256 random bits (`cagefit token`), which nobody finds by trying: plain SHA-256 is
// enough here, where salts and slow hashes are for passwords, of which there are few.
#ifndef CAGEFIT_SERVER_SESSION_TOKEN_TABLE_H_
#define CAGEFIT_SERVER_SESSION_TOKEN_TABLE_H_

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "absl/time/time.h"
#include "server/session/digest.h"
#include "server/session/principal.h"

namespace cagefit::server {

// Immutable.
class TokenTable {
 public:
  static constexpr size_t kMaxTokens = 4096;
  static constexpr size_t kMaxTokenBytes = 256;

  // INVALID_ARGUMENT, "FILE:LINE: what is wrong"; never with a token or digest in it. What the
  // principals of `before` (may be null) have used of their quotas goes on counting.
  static absl::StatusOr<TokenTable> Parse(const std::string& file, absl::string_view text,
                                          const TokenTable* before);

  // Whose token it is; null when nobody's, or expired at `now`. Takes as long for one as for
  // another, whichever bytes of whichever digest are equal.
  std::shared_ptr<const Principal> Find(absl::string_view token, absl::Time now) const;

  size_t token_count() const { return tokens_.size(); }

 private:
  struct Token {
    Digest digest;
    absl::Time expires = absl::InfiniteFuture();
    std::shared_ptr<const Principal> principal;
  };

  absl::Status AddLine(absl::string_view line, const TokenTable* before);
  absl::StatusOr<std::shared_ptr<const Principal>> PrincipalOf(const std::string& name,
                                                               const Quotas& quotas,
                                                               const TokenTable* before);

  std::vector<Token> tokens_;
  std::map<std::string, std::shared_ptr<const Principal>> principals_;
};

}  // namespace cagefit::server

#endif  // CAGEFIT_SERVER_SESSION_TOKEN_TABLE_H_
