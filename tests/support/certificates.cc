#include "tests/support/certificates.h"

#include <openssl/bio.h>
#include <openssl/ec.h>
#include <openssl/pem.h>
#include <openssl/x509v3.h>

#include <cstdio>
#include <cstdlib>

namespace cagefit::testing {
namespace {

constexpr long kDay = 24 * 3600;

template <typename T>
T Need(T result) {
  if (result) return result;
  std::fputs("OpenSSL failed in a test\n", stderr);
  std::abort();
}

template <typename Write>
std::string Pem(const Write& write) {
  BIO* bio = Need(BIO_new(BIO_s_mem()));
  Need(write(bio));
  char* bytes = nullptr;
  const long size = BIO_get_mem_data(bio, &bytes);
  std::string pem(bytes, static_cast<size_t>(size));
  BIO_free(bio);
  return pem;
}

std::string CertificatePem(X509* certificate) {
  return Pem([certificate](BIO* bio) { return PEM_write_bio_X509(bio, certificate); });
}

void SetName(X509_NAME* name, const std::string& common_name) {
  if (common_name.empty()) return;
  Need(X509_NAME_add_entry_by_txt(name, "CN", MBSTRING_UTF8,
                                  reinterpret_cast<const unsigned char*>(common_name.c_str()), -1,
                                  -1, 0));
}

void AddExtension(X509* certificate, X509* issuer, int nid, const std::string& value) {
  X509V3_CTX context;
  X509V3_set_ctx(&context, issuer, certificate, nullptr, nullptr, 0);
  X509_EXTENSION* extension = Need(X509V3_EXT_conf_nid(nullptr, &context, nid, value.c_str()));
  Need(X509_add_ext(certificate, extension, -1));
  X509_EXTENSION_free(extension);
}

X509* NewCertificate(EVP_PKEY* key, long serial, const std::string& common_name) {
  X509* certificate = Need(X509_new());
  Need(X509_set_version(certificate, 2));
  Need(ASN1_INTEGER_set(X509_get_serialNumber(certificate), serial));
  X509_gmtime_adj(X509_getm_notBefore(certificate), -kDay);
  X509_gmtime_adj(X509_getm_notAfter(certificate), kDay);
  SetName(X509_get_subject_name(certificate), common_name);
  Need(X509_set_pubkey(certificate, key));
  return certificate;
}

}  // namespace

CertificateAuthority::CertificateAuthority(const std::string& name)
    : key_(Need(EVP_EC_gen("P-256"))), own_(NewCertificate(key_.get(), serial_++, name)) {
  Need(X509_set_issuer_name(own_.get(), X509_get_subject_name(own_.get())));
  AddExtension(own_.get(), own_.get(), NID_basic_constraints, "critical,CA:TRUE");
  AddExtension(own_.get(), own_.get(), NID_key_usage, "critical,keyCertSign,cRLSign");
  Need(X509_sign(own_.get(), key_.get(), EVP_sha256()));
  certificate_ = CertificatePem(own_.get());
}

CertificateAndKey CertificateAuthority::Issue(const std::string& common_name,
                                              const std::string& uri) {
  return Sign(common_name,
              "DNS:localhost,IP:127.0.0.1,IP:::1" + (uri.empty() ? "" : ",URI:" + uri));
}

CertificateAndKey CertificateAuthority::IssueClient(const std::string& common_name,
                                                    const std::string& uri) {
  return Sign(common_name, uri.empty() ? "" : "URI:" + uri);
}

CertificateAndKey CertificateAuthority::Sign(const std::string& common_name,
                                             const std::string& alternative_names) {
  const std::unique_ptr<EVP_PKEY, Free> key(Need(EVP_EC_gen("P-256")));
  const std::unique_ptr<X509, Free> certificate(NewCertificate(key.get(), serial_++, common_name));
  Need(X509_set_issuer_name(certificate.get(), X509_get_subject_name(own_.get())));
  if (!alternative_names.empty()) {
    AddExtension(certificate.get(), own_.get(), NID_subject_alt_name, alternative_names);
  }
  Need(X509_sign(certificate.get(), key_.get(), EVP_sha256()));
  CertificateAndKey made;
  made.certificate = CertificatePem(certificate.get());
  made.key = Pem([&key](BIO* bio) {
    return PEM_write_bio_PrivateKey(bio, key.get(), nullptr, nullptr, 0, nullptr, nullptr);
  });
  return made;
}

std::string KeyUnderPassword() {
  EVP_PKEY* key = Need(EVP_EC_gen("P-256"));
  std::string pem = Pem([key](BIO* bio) {
    unsigned char password[] = "password";
    return PEM_write_bio_PrivateKey(bio, key, EVP_aes_256_cbc(), password, sizeof(password) - 1,
                                    nullptr, nullptr);
  });
  EVP_PKEY_free(key);
  return pem;
}

}  // namespace cagefit::testing
