// cagefit: the command line client.
#include <cstdlib>
#include <exception>
#include <iostream>

#include "client/commands/command.h"
#include "client/commands/parse.h"

int main(int argc, char** argv) try {
  // gRPC writes to standard error for itself; what matters comes as a status.
  setenv("GRPC_VERBOSITY", "NONE", /*overwrite=*/0);
  return cagefit::client::RunCommandLine(argc, argv);
} catch (const std::exception& error) {
  std::cerr << "cagefit: " << error.what() << "\n";
  return cagefit::client::kFailed;
}
