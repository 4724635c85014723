// From what settings call a store to the store.
#ifndef CAGEFIT_SERVER_STORE_OPEN_JOURNAL_H_
#define CAGEFIT_SERVER_STORE_OPEN_JOURNAL_H_

#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "server/session/journal.h"
#include "server/session/metrics.h"
#include "server/session/record_codec.h"

namespace cagefit::server {

inline constexpr char kStores[] = "memory, sqlite:PATH or postgres:URL";

// INVALID_ARGUMENT, naming what was expected, for another name than those of kStores.
absl::Status CheckStoreName(const std::string& name);

// A file of SQLite, whose folder is made where it is missing, or a database of PostgreSQL, which
// many servers may share. `codec`, and `commits`, which may be null and is told how long commits of
// answers take, must outlive the journal. INVALID_ARGUMENT for another name; FAILED_PRECONDITION
// naming the store when that cannot be one of this version (SqlJournal::Open).
absl::StatusOr<std::unique_ptr<Journal>> OpenJournal(const std::string& name,
                                                     const RecordCodec* codec,
                                                     LatencyHistogram* commits = nullptr);

}  // namespace cagefit::server

#endif  // CAGEFIT_SERVER_STORE_OPEN_JOURNAL_H_
