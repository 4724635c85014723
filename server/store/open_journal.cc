#include "server/store/open_journal.h"

#include <filesystem>
#include <system_error>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/strip.h"
#include "core/base/status.h"
#include "server/store/memory_journal.h"
#include "server/store/postgres.h"
#include "server/store/sql_journal.h"
#include "server/store/sqlite.h"

namespace cagefit::server {
namespace {

// What a database takes at a time from one server: more than its workers write.
constexpr int kPostgresConnections = 4;

absl::Status MakeFolder(const std::filesystem::path& file) {
  std::error_code error;
  if (file.has_parent_path()) std::filesystem::create_directories(file.parent_path(), error);
  if (!error) return absl::OkStatus();
  return absl::FailedPreconditionError(
      absl::StrCat("cannot make the folder of the session store, ", file.parent_path().string(),
                   ": ", error.message(), "; name another with --store, or --store memory"));
}

struct Place {
  std::string path, url;  // one of them
};

absl::StatusOr<Place> PlaceOf(const std::string& name) {
  absl::string_view rest = name;
  if (absl::ConsumePrefix(&rest, "sqlite:") && !rest.empty()) return Place{std::string(rest), ""};
  if (absl::ConsumePrefix(&rest, "postgres:") && !rest.empty()) {
    // postgres://HOST/NAME is what libpq itself takes.
    const std::string url = rest.substr(0, 2) == "//" ? name : std::string(rest);
    const absl::Status understood = CheckPostgresUrl(url);
    if (understood.ok()) return Place{"", url};
    return absl::InvalidArgumentError(
        absl::StrCat("store is postgres: with a URL that is none: ", understood.message()));
  }
  return absl::InvalidArgumentError(absl::StrCat("store is ", name, "; expected ", kStores));
}

}  // namespace

absl::Status CheckStoreName(const std::string& name) {
  return name == "memory" ? absl::OkStatus() : PlaceOf(name).status();
}

absl::StatusOr<std::unique_ptr<Journal>> OpenJournal(const std::string& name,
                                                     const RecordCodec* codec,
                                                     LatencyHistogram* commits) {
  if (name == "memory") return std::make_unique<MemoryJournal>();
  ASSIGN_OR_RETURN(const Place place, PlaceOf(name));
  if (!place.path.empty()) RETURN_IF_ERROR(MakeFolder(place.path));
  SqlJournal::ConnectFn connect;
  if (!place.path.empty()) {
    connect = [path = place.path] { return SqliteDatabase::Open(path); };
  } else {
    connect = [url = place.url] { return PostgresDatabase::Open(url); };
  }
  auto journal = SqlJournal::Open(std::move(connect), place.path.empty() ? kPostgresConnections : 1,
                                  codec, commits);
  if (journal.ok()) return *std::move(journal);
  return absl::Status(journal.status().code(),
                      absl::StrCat(name, ": ", journal.status().message()));
}

}  // namespace cagefit::server
