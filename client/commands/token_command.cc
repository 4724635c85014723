#include <fcntl.h>
#include <openssl/evp.h>
#include <openssl/rand.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <iostream>
#include <memory>
#include <optional>
#include <string>

#include "absl/strings/escaping.h"
#include "absl/strings/str_cat.h"
#include "absl/time/time.h"
#include "client/commands/command.h"
#include "core/base/status.h"

namespace cagefit::client {
namespace {

struct TokenArguments {
  std::string name, out, expires;
  std::optional<int64_t> sessions, bytes_per_second, fits;
};

// 256 random bits: nobody finds them by trying, so the server keeps a plain SHA-256 of them.
absl::StatusOr<std::string> MakeToken() {
  unsigned char random[32];
  if (RAND_bytes(random, sizeof(random)) != 1) {
    return absl::InternalError("this machine gives no random numbers");
  }
  return absl::StrCat("cft_", absl::WebSafeBase64Escape(absl::string_view(
                                  reinterpret_cast<const char*>(random), sizeof(random))));
}

absl::StatusOr<std::string> Sha256Hex(const std::string& token) {
  unsigned char digest[32];
  if (EVP_Digest(token.data(), token.size(), digest, nullptr, EVP_sha256(), nullptr) != 1) {
    return absl::InternalError("OpenSSL has no SHA-256");
  }
  return absl::BytesToHexString(
      absl::string_view(reinterpret_cast<const char*>(digest), sizeof(digest)));
}

// A new file that only this user may read.
absl::Status WriteSecret(const std::string& path, const std::string& text) {
  const int file = open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
  const bool written =
      file >= 0 && write(file, text.data(), text.size()) == static_cast<ssize_t>(text.size());
  const int error = errno;
  if (file >= 0) close(file);
  if (written) return absl::OkStatus();
  return absl::FailedPreconditionError(
      absl::StrCat(path, ": cannot be written: ", std::strerror(error)));
}

absl::Status Make(const TokenArguments& a) {
  ASSIGN_OR_RETURN(const std::string token, MakeToken());
  ASSIGN_OR_RETURN(std::string line, Sha256Hex(token));
  line = absl::StrCat(a.name, " ", line);
  if (a.sessions.has_value()) absl::StrAppend(&line, " sessions=", *a.sessions);
  if (a.bytes_per_second.has_value()) {
    absl::StrAppend(&line, " bytes-per-second=", *a.bytes_per_second);
  }
  if (a.fits.has_value()) absl::StrAppend(&line, " fits=", *a.fits);
  if (!a.expires.empty()) absl::StrAppend(&line, " expires=", a.expires);
  RETURN_IF_ERROR(WriteSecret(a.out, token + "\n"));
  std::cout << line << "\n";
  return absl::OkStatus();
}

std::string CheckName(const std::string& name) {
  const bool good = !name.empty() && name.size() <= 64 &&
                    name.find_first_not_of(
                        "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz"
                        "0123456789.-_") == std::string::npos;
  return good ? "" : "expected 1 to 64 letters, digits, dots, dashes and underscores";
}

std::string CheckTime(const std::string& text) {
  absl::Time time;
  std::string error;
  if (absl::ParseTime(absl::RFC3339_full, text, &time, &error)) return "";
  return "expected a time as 2026-12-31T18:00:00Z";
}

}  // namespace

void AddTokenCommand(CLI::App* app, Run* run) {
  const auto a = std::make_shared<TokenArguments>();
  CLI::App* command = app->add_subcommand(
      "token", "Make a token: write it to a file, print the line for the server's --tokens file");
  command->add_option("NAME", a->name, "Who has it; sessions belong to the name")
      ->required()
      ->check(CLI::Validator(CheckName, "NAME"));
  command->add_option("--out", a->out, "New file for the token, for cagefit --token-file")
      ->required();
  const CLI::Range positive(int64_t{1}, INT64_MAX);
  command->add_option("--sessions", a->sessions, "Sessions at a time")->check(positive);
  command->add_option("--bytes-per-second", a->bytes_per_second, "That the server takes")
      ->check(positive);
  command->add_option("--fits", a->fits, "Concurrent fits")->check(positive);
  command->add_option("--expires", a->expires, "Until when it is good, RFC 3339")
      ->check(CLI::Validator(CheckTime, "TIME"));
  command->callback([a, run] {
    *run = [a] {
      const absl::Status made = Make(*a);
      return made.ok() ? static_cast<int>(kDone) : Report(made);
    };
  });
}

}  // namespace cagefit::client
