// The file of tokens that a server takes, read again when it changes.
#ifndef CAGEFIT_SERVER_SESSION_TOKEN_FILE_H_
#define CAGEFIT_SERVER_SESSION_TOKEN_FILE_H_

#include <functional>
#include <memory>
#include <mutex>
#include <string>

#include "absl/status/statusor.h"
#include "server/session/file_watch.h"
#include "server/session/token_table.h"

namespace cagefit::server {

// Thread-safe.
class TokenFile {
 public:
  // Told of every change: OK when the new tokens are in force, or why the old ones stay so. On a
  // thread of the file's own.
  using ReloadedFn = std::function<void(const absl::Status& status, size_t tokens)>;

  // INVALID_ARGUMENT naming file and line, FAILED_PRECONDITION naming a file that cannot be read.
  static absl::StatusOr<std::unique_ptr<TokenFile>> Open(const std::string& path,
                                                         absl::Duration poll, ReloadedFn reloaded);

  // As TokenTable::Find, by the tokens in force.
  std::shared_ptr<const Principal> Find(absl::string_view token, absl::Time now) const;

 private:
  TokenFile(std::string path, TokenTable table, ReloadedFn reloaded)
      : path_(std::move(path)),
        reloaded_(std::move(reloaded)),
        table_(std::make_shared<TokenTable>(std::move(table))) {}
  std::shared_ptr<const TokenTable> Table() const;
  absl::Status Reload(const FileContents& contents);

  const std::string path_;
  const ReloadedFn reloaded_;
  mutable std::mutex mutex_;  // held to copy or set a pointer
  std::shared_ptr<const TokenTable> table_;
  std::unique_ptr<FileWatch> watch_;  // ends first
};

}  // namespace cagefit::server

#endif  // CAGEFIT_SERVER_SESSION_TOKEN_FILE_H_
