#include "server/session/token_file.h"

#include <utility>

#include "core/base/status.h"

namespace cagefit::server {

absl::StatusOr<std::unique_ptr<TokenFile>> TokenFile::Open(const std::string& path,
                                                           absl::Duration poll,
                                                           ReloadedFn reloaded) {
  const FileContents contents = ReadFiles({path});
  RETURN_IF_ERROR(contents.status());
  ASSIGN_OR_RETURN(TokenTable table, TokenTable::Parse(path, contents->front(), nullptr));
  std::unique_ptr<TokenFile> file(new TokenFile(path, std::move(table), std::move(reloaded)));
  TokenFile* const self = file.get();
  file->watch_ = std::make_unique<FileWatch>(
      std::vector<std::string>{path}, contents, poll, [self](const FileContents& changed) {
        const absl::Status status = self->Reload(changed);
        self->reloaded_(status, self->Table()->token_count());
      });
  return file;
}

absl::Status TokenFile::Reload(const FileContents& contents) {
  RETURN_IF_ERROR(contents.status());
  const std::shared_ptr<const TokenTable> before = Table();
  ASSIGN_OR_RETURN(TokenTable table, TokenTable::Parse(path_, contents->front(), before.get()));
  auto after = std::make_shared<const TokenTable>(std::move(table));
  std::lock_guard<std::mutex> lock(mutex_);
  table_ = std::move(after);
  return absl::OkStatus();
}

std::shared_ptr<const TokenTable> TokenFile::Table() const {
  std::lock_guard<std::mutex> lock(mutex_);
  return table_;
}

std::shared_ptr<const Principal> TokenFile::Find(absl::string_view token, absl::Time now) const {
  return Table()->Find(token, now);
}

}  // namespace cagefit::server
