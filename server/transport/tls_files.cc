#include "server/transport/tls_files.h"

#include "core/base/status.h"

namespace cagefit::server {

absl::StatusOr<std::unique_ptr<TlsFiles>> TlsFiles::Open(const TlsPaths& paths, absl::Duration poll,
                                                         ReloadedFn reloaded) {
  const FileContents contents = ReadFiles(paths.All());
  RETURN_IF_ERROR(contents.status());
  ASSIGN_OR_RETURN(TlsIdentity identity, ParseTlsIdentity(paths, *contents));
  std::unique_ptr<TlsFiles> files(new TlsFiles(paths, std::move(identity), std::move(reloaded)));
  TlsFiles* const self = files.get();
  files->watch_ = std::make_unique<FileWatch>(
      paths.All(), contents, poll,
      [self](const FileContents& changed) { self->reloaded_(self->Reload(changed)); });
  return files;
}

absl::Status TlsFiles::Reload(const FileContents& contents) {
  RETURN_IF_ERROR(contents.status());
  ASSIGN_OR_RETURN(TlsIdentity identity, ParseTlsIdentity(paths_, *contents));
  auto changed = std::make_shared<const TlsIdentity>(std::move(identity));
  std::lock_guard<std::mutex> lock(mutex_);
  identity_ = std::move(changed);
  return absl::OkStatus();
}

std::shared_ptr<const TlsIdentity> TlsFiles::identity() const {
  std::lock_guard<std::mutex> lock(mutex_);
  return identity_;
}

}  // namespace cagefit::server
