// A server's TLS files, read again when they change.
#ifndef CAGEFIT_SERVER_TRANSPORT_TLS_FILES_H_
#define CAGEFIT_SERVER_TRANSPORT_TLS_FILES_H_

#include <functional>
#include <memory>
#include <mutex>
#include <utility>

#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "server/session/file_watch.h"
#include "server/transport/tls_identity.h"

namespace cagefit::server {

// Thread-safe.
class TlsFiles {
 public:
  // Told of every change: OK when the new files are in force, or why the old ones stay so. On a
  // thread of the files' own.
  using ReloadedFn = std::function<void(const absl::Status& status)>;

  // INVALID_ARGUMENT or FAILED_PRECONDITION, naming the file, for what cannot be used or read.
  static absl::StatusOr<std::unique_ptr<TlsFiles>> Open(const TlsPaths& paths, absl::Duration poll,
                                                        ReloadedFn reloaded);

  bool wants_client_certificates() const { return !paths_.client_roots.empty(); }
  // In force.
  std::shared_ptr<const TlsIdentity> identity() const;

 private:
  TlsFiles(TlsPaths paths, TlsIdentity identity, ReloadedFn reloaded)
      : paths_(std::move(paths)),
        reloaded_(std::move(reloaded)),
        identity_(std::make_shared<TlsIdentity>(std::move(identity))) {}
  absl::Status Reload(const FileContents& contents);

  const TlsPaths paths_;
  const ReloadedFn reloaded_;
  mutable std::mutex mutex_;  // held to copy or set a pointer
  std::shared_ptr<const TlsIdentity> identity_;
  std::unique_ptr<FileWatch> watch_;  // ends first
};

}  // namespace cagefit::server

#endif  // CAGEFIT_SERVER_TRANSPORT_TLS_FILES_H_
