// Certificates in a folder, and settings of servers and clients that use them.
#ifndef CAGEFIT_TESTS_SERVER_TLS_FOLDER_H_
#define CAGEFIT_TESTS_SERVER_TLS_FOLDER_H_

#include <filesystem>
#include <fstream>
#include <string>

#include "client/credentials.h"
#include "core/base/private_folder.h"
#include "server/server_options.h"
#include "tests/support/certificates.h"

namespace cagefit::server::testing {

class TlsFolder {
 public:
  TlsFolder() {
    Write("ca.pem", authority_.certificate());
    WriteServer(authority_.Issue("server"));
  }

  cagefit::testing::CertificateAuthority& authority() { return authority_; }

  // In one step, as tools that renew certificates do. Returns its path.
  std::string Write(const std::string& name, const std::string& text) {
    std::ofstream(Path("new")) << text;
    std::filesystem::rename(Path("new"), Path(name));
    return Path(name);
  }
  void WriteServer(const cagefit::testing::CertificateAndKey& server) {
    Write("server.pem", server.certificate);
    Write("server.key", server.key);
  }

  ServerOptions Options() const {
    ServerOptions options;
    options.listen = {"127.0.0.1:0"};
    options.tls_cert = Path("server.pem");
    options.tls_key = Path("server.key");
    return options;
  }
  ServerOptions OptionsWithClients() const {
    ServerOptions options = Options();
    options.tls_client_ca = Path("ca.pem");
    return options;
  }

  client::ClientCredentials Trusting() const {
    client::ClientCredentials credentials;
    credentials.ca_file = Path("ca.pem");
    return credentials;
  }
  // `name`: of the files.
  client::ClientCredentials Client(const std::string& name,
                                   const cagefit::testing::CertificateAndKey& own) {
    client::ClientCredentials credentials = Trusting();
    credentials.cert_file = Write(name + ".pem", own.certificate);
    credentials.key_file = Write(name + ".key", own.key);
    return credentials;
  }

 private:
  std::string Path(const std::string& name) const { return folder_.path() + "/" + name; }

  PrivateFolder folder_ = PrivateFolder::Create().value();
  cagefit::testing::CertificateAuthority authority_{"authority"};
};

}  // namespace cagefit::server::testing

#endif  // CAGEFIT_TESTS_SERVER_TLS_FOLDER_H_
