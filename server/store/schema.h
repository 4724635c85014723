// Tables of a store, and how an older store becomes a current one.
#ifndef CAGEFIT_SERVER_STORE_SCHEMA_H_
#define CAGEFIT_SERVER_STORE_SCHEMA_H_

#include <string>
#include <vector>

#include "absl/status/status.h"
#include "server/store/database.h"

namespace cagefit::server {

// Step k makes version k + 1 of version k; version 0 is an empty store. Never changed once
// released: what comes later is another step. Names in braces are fields of SqlDialect.
const std::vector<std::string>& SchemaSteps();

// Takes the steps that the store lacks, each in a transaction. FAILED_PRECONDITION for a store of
// another program, and for one of a later version, which is left as it is; UNAVAILABLE.
absl::Status Migrate(Database* database, const std::vector<std::string>& steps);

}  // namespace cagefit::server

#endif  // CAGEFIT_SERVER_STORE_SCHEMA_H_
