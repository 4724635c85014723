#include "server/store/open_journal.h"

#include <filesystem>
#include <system_error>

#include "absl/strings/str_cat.h"
#include "absl/strings/strip.h"
#include "server/store/memory_journal.h"
#include "server/store/sqlite_journal.h"

namespace cagefit::server {

absl::StatusOr<std::unique_ptr<Journal>> OpenJournal(const std::string& name,
                                                     const RecordCodec* codec,
                                                     LatencyHistogram* commits) {
  if (name == "memory") return std::make_unique<MemoryJournal>();
  absl::string_view path = name;
  if (!absl::ConsumePrefix(&path, "sqlite:") || path.empty()) {
    return absl::InvalidArgumentError(
        absl::StrCat("store is ", name, "; expected memory or sqlite:PATH"));
  }
  const std::filesystem::path file = std::string(path);
  std::error_code error;
  if (file.has_parent_path()) std::filesystem::create_directories(file.parent_path(), error);
  if (error) {
    return absl::FailedPreconditionError(
        absl::StrCat("cannot make the folder of the session store, ", file.parent_path().string(),
                     ": ", error.message(), "; name another with --store, or --store memory"));
  }
  return SqliteJournal::Open(std::string(path), codec, commits);
}

}  // namespace cagefit::server
