#include "client/commands/command.h"

#include <iostream>

namespace cagefit::client {

int Report(const absl::Status& status) {
  std::cerr << "cagefit: " << status.message() << "\n";
  return absl::IsUnavailable(status) ? kNoServer : kFailed;
}

}  // namespace cagefit::client
