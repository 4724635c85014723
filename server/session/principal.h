// Who calls, and what they may have.
#ifndef CAGEFIT_SERVER_SESSION_PRINCIPAL_H_
#define CAGEFIT_SERVER_SESSION_PRINCIPAL_H_

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "server/session/byte_rate.h"
#include "server/session/fit_share.h"

namespace cagefit::server {

// Not set: no limit but the server's.
struct Quotas {
  std::optional<int64_t> sessions;          // at a time, 1 or more
  std::optional<int64_t> bytes_per_second;  // received by all calls together, 1 or more
  std::optional<int64_t> fits;              // in work at a time, 1 or more

  bool operator==(const Quotas& other) const {
    return sessions == other.sessions && bytes_per_second == other.bytes_per_second &&
           fits == other.fits;
  }
};

struct Principal {
  // Sessions belong to it. Empty: anybody, where a server asks nobody who they are.
  std::string name;
  Quotas quotas;
  // What is used of the quotas: one of each for all calls and all tokens of one name.
  std::shared_ptr<ByteRate> rate = std::make_shared<ByteRate>();
  std::shared_ptr<FitShare> fits = std::make_shared<FitShare>();
};

}  // namespace cagefit::server

#endif  // CAGEFIT_SERVER_SESSION_PRINCIPAL_H_
