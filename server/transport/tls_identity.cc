#include "server/transport/tls_identity.h"

#include <openssl/bio.h>
#include <openssl/err.h>
#include <openssl/pem.h>
#include <openssl/x509.h>

#include <memory>

#include "absl/strings/str_cat.h"
#include "core/base/status.h"

namespace cagefit::server {
namespace {

struct FreeBio {
  void operator()(BIO* bio) const { BIO_free(bio); }
};
struct FreeX509 {
  void operator()(X509* certificate) const { X509_free(certificate); }
};
struct FreeKey {
  void operator()(EVP_PKEY* key) const { EVP_PKEY_free(key); }
};
using Bio = std::unique_ptr<BIO, FreeBio>;
using Certificate = std::unique_ptr<X509, FreeX509>;
using Key = std::unique_ptr<EVP_PKEY, FreeKey>;

// OpenSSL would ask the terminal.
int NoPassword(char*, int, int, void*) { return 0; }

Bio BioOf(const std::string& text) {
  return Bio(BIO_new_mem_buf(text.data(), static_cast<int>(text.size())));
}

absl::StatusOr<Certificate> FirstCertificate(const std::string& path, const std::string& text) {
  const Bio bio = BioOf(text);
  Certificate certificate(PEM_read_bio_X509(bio.get(), nullptr, NoPassword, nullptr));
  ERR_clear_error();
  if (certificate == nullptr) {
    return absl::InvalidArgumentError(absl::StrCat(path, ": holds no certificate in PEM format"));
  }
  return certificate;
}

}  // namespace

std::vector<std::string> TlsPaths::All() const {
  std::vector<std::string> all = {certificates, key};
  if (!client_roots.empty()) all.push_back(client_roots);
  return all;
}

absl::StatusOr<TlsIdentity> ParseTlsIdentity(const TlsPaths& paths,
                                             const std::vector<std::string>& contents) {
  ASSIGN_OR_RETURN(const Certificate certificate,
                   FirstCertificate(paths.certificates, contents[0]));
  const Bio bio = BioOf(contents[1]);
  const Key key(PEM_read_bio_PrivateKey(bio.get(), nullptr, NoPassword, nullptr));
  const bool matches = key != nullptr && X509_check_private_key(certificate.get(), key.get()) == 1;
  ERR_clear_error();
  if (key == nullptr) {
    return absl::InvalidArgumentError(
        absl::StrCat(paths.key, ": holds no key in PEM format, or one under a password"));
  }
  if (!matches) {
    return absl::InvalidArgumentError(
        absl::StrCat(paths.key, ": is not the key of the certificate in ", paths.certificates));
  }
  TlsIdentity identity = {contents[0], contents[1], ""};
  if (!paths.client_roots.empty()) {
    RETURN_IF_ERROR(FirstCertificate(paths.client_roots, contents[2]).status());
    identity.client_roots = contents[2];
  }
  return identity;
}

}  // namespace cagefit::server
