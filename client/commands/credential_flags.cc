#include "client/commands/credential_flags.h"

namespace cagefit::client {

void AddCredentialFlags(ClientCredentials* c, CLI::App* command) {
  command->add_flag("--tls", c->tls, "The server has a certificate that this system trusts");
  command->add_option("--tls-ca", c->ca_file,
                      "The server has a certificate of one of these authorities, PEM file");
  command->add_option("--tls-cert", c->cert_file, "This client's certificate, PEM file");
  command->add_option("--tls-key", c->key_file, "Its key, PEM file");
  command->add_option("--token-file", c->token_file, "File with this client's token");
  command->add_flag("--plain-token", c->plain_token,
                    "Let the token go to another machine without TLS");
}

}  // namespace cagefit::client
