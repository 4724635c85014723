// Flags of every command that talks to a server.
#ifndef CAGEFIT_CLIENT_COMMANDS_CREDENTIAL_FLAGS_H_
#define CAGEFIT_CLIENT_COMMANDS_CREDENTIAL_FLAGS_H_

#include <CLI/CLI.hpp>

#include "client/credentials.h"

namespace cagefit::client {

// Secrets come in files, never as flags: those are for all users of the machine to see.
void AddCredentialFlags(ClientCredentials* credentials, CLI::App* command);

}  // namespace cagefit::client

#endif  // CAGEFIT_CLIENT_COMMANDS_CREDENTIAL_FLAGS_H_
