#include "server/session/token_table.h"

#include <openssl/crypto.h>

#include <algorithm>
#include <optional>
#include <set>
#include <utility>

#include "absl/strings/ascii.h"
#include "absl/strings/escaping.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "core/base/status.h"

namespace cagefit::server {
namespace {

constexpr size_t kMaxNameBytes = 64;

absl::Status CheckName(absl::string_view name) {
  const bool good =
      name.size() <= kMaxNameBytes && std::all_of(name.begin(), name.end(), [](unsigned char c) {
        return absl::ascii_isalnum(c) || c == '.' || c == '-' || c == '_';
      });
  // Not quoted: somebody may have put the token first.
  if (good) return absl::OkStatus();
  return absl::InvalidArgumentError(
      "the name has to be 1 to 64 letters, digits, dots, dashes and underscores");
}

absl::StatusOr<Digest> ParseDigest(absl::string_view hex) {
  Digest digest;
  if (hex.size() != 2 * digest.size() || !std::all_of(hex.begin(), hex.end(), [](unsigned char c) {
        return absl::ascii_isxdigit(c);
      })) {
    return absl::InvalidArgumentError(
        "expected the token's SHA-256, 64 hexadecimal digits, after the name");
  }
  const std::string bytes = absl::HexStringToBytes(hex);
  std::copy(bytes.begin(), bytes.end(), digest.begin());
  return digest;
}

absl::Status ParseCount(absl::string_view name, absl::string_view value,
                        std::optional<int64_t>* count) {
  int64_t number = 0;
  if (!absl::SimpleAtoi(value, &number) || number < 1) {
    return absl::InvalidArgumentError(
        absl::StrCat(name, " is \"", absl::CEscape(value), "\"; expected a number from 1 up"));
  }
  *count = number;
  return absl::OkStatus();
}

absl::Status ParseTime(absl::string_view value, absl::Time* time) {
  std::string error;
  if (absl::ParseTime(absl::RFC3339_full, value, time, &error)) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrCat("expires is \"", absl::CEscape(value),
                                                 "\"; expected a time as 2026-12-31T18:00:00Z"));
}

absl::Status ParseSetting(absl::string_view setting, Quotas* quotas, absl::Time* expires) {
  const std::pair<absl::string_view, absl::string_view> parts =
      absl::StrSplit(setting, absl::MaxSplits('=', 1));
  if (parts.first == "sessions") return ParseCount("sessions", parts.second, &quotas->sessions);
  if (parts.first == "bytes-per-second") {
    return ParseCount("bytes-per-second", parts.second, &quotas->bytes_per_second);
  }
  if (parts.first == "fits") return ParseCount("fits", parts.second, &quotas->fits);
  if (parts.first == "expires") return ParseTime(parts.second, expires);
  return absl::InvalidArgumentError(
      "unknown setting; expected sessions=N, bytes-per-second=N, fits=N or expires=TIME");
}

}  // namespace

absl::StatusOr<TokenTable> TokenTable::Parse(const std::string& file, absl::string_view text,
                                             const TokenTable* before) {
  TokenTable table;
  int number = 0;
  for (absl::string_view line : absl::StrSplit(text, '\n')) {
    ++number;
    line = absl::StripAsciiWhitespace(line.substr(0, line.find('#')));
    if (line.empty()) continue;
    const absl::Status added = table.AddLine(line, before);
    if (!added.ok()) {
      return absl::InvalidArgumentError(absl::StrCat(file, ":", number, ": ", added.message()));
    }
  }
  return table;
}

absl::Status TokenTable::AddLine(absl::string_view line, const TokenTable* before) {
  if (tokens_.size() == kMaxTokens) {
    return absl::InvalidArgumentError(absl::StrCat("more than ", kMaxTokens, " tokens"));
  }
  const std::vector<absl::string_view> words =
      absl::StrSplit(line, absl::ByAnyChar(" \t\r"), absl::SkipEmpty());
  RETURN_IF_ERROR(CheckName(words[0]));
  Token token;
  ASSIGN_OR_RETURN(token.digest, ParseDigest(words.size() > 1 ? words[1] : ""));
  for (const Token& other : tokens_) {
    if (other.digest == token.digest) {
      return absl::InvalidArgumentError("the same SHA-256 as in an earlier line");
    }
  }
  Quotas quotas;
  std::set<absl::string_view> seen;
  for (size_t k = 2; k < words.size(); ++k) {
    RETURN_IF_ERROR(ParseSetting(words[k], &quotas, &token.expires));
    if (!seen.insert(words[k].substr(0, words[k].find('='))).second) {
      return absl::InvalidArgumentError("the same setting twice");
    }
  }
  ASSIGN_OR_RETURN(token.principal, PrincipalOf(std::string(words[0]), quotas, before));
  tokens_.push_back(std::move(token));
  return absl::OkStatus();
}

absl::StatusOr<std::shared_ptr<const Principal>> TokenTable::PrincipalOf(const std::string& name,
                                                                         const Quotas& quotas,
                                                                         const TokenTable* before) {
  std::shared_ptr<const Principal>& known = principals_[name];
  if (known == nullptr) {
    auto principal = std::make_shared<Principal>();
    principal->name = name;
    principal->quotas = quotas;
    if (before != nullptr) {
      const auto old = before->principals_.find(name);
      if (old != before->principals_.end()) {
        principal->rate = old->second->rate;
        principal->fits = old->second->fits;
      }
    }
    known = std::move(principal);
  } else if (!(known->quotas == quotas)) {
    return absl::InvalidArgumentError(
        absl::StrCat("other quotas than in an earlier line of ", name));
  }
  return known;
}

std::shared_ptr<const Principal> TokenTable::Find(absl::string_view token, absl::Time now) const {
  if (token.empty() || token.size() > kMaxTokenBytes) return nullptr;
  const Digest digest = Sha256(token);
  const Token* found = nullptr;
  for (const Token& candidate : tokens_) {
    // Every digest is compared, and every byte of it.
    if (CRYPTO_memcmp(candidate.digest.data(), digest.data(), digest.size()) == 0) {
      found = &candidate;
    }
  }
  if (found == nullptr || found->expires <= now) return nullptr;
  return found->principal;
}

}  // namespace cagefit::server
