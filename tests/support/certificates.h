// Certificates for tests, made when they are needed.
#ifndef CAGEFIT_TESTS_SUPPORT_CERTIFICATES_H_
#define CAGEFIT_TESTS_SUPPORT_CERTIFICATES_H_

#include <openssl/evp.h>
#include <openssl/x509.h>

#include <memory>
#include <string>

namespace cagefit::testing {

struct CertificateAndKey {
  std::string certificate, key;  // PEM
};

// Trusts itself; aborts the test program when OpenSSL fails.
class CertificateAuthority {
 public:
  explicit CertificateAuthority(const std::string& name);

  const std::string& certificate() const { return certificate_; }  // PEM

  // Good for a server at localhost, 127.0.0.1 and ::1, and for a client. An empty name leaves the
  // certificate without a common name; `uri`, where not empty, is one more alternative name.
  CertificateAndKey Issue(const std::string& common_name, const std::string& uri = "");
  // For clients only: with no alternative name but `uri`, if any.
  CertificateAndKey IssueClient(const std::string& common_name, const std::string& uri = "");

 private:
  struct Free {
    void operator()(EVP_PKEY* key) const { EVP_PKEY_free(key); }
    void operator()(X509* certificate) const { X509_free(certificate); }
  };
  CertificateAndKey Sign(const std::string& common_name, const std::string& alternative_names);

  std::unique_ptr<EVP_PKEY, Free> key_;
  std::unique_ptr<X509, Free> own_;
  std::string certificate_;
  long serial_ = 1;
};

// A key in PEM format that only its password opens.
std::string KeyUnderPassword();

}  // namespace cagefit::testing

#endif  // CAGEFIT_TESTS_SUPPORT_CERTIFICATES_H_
