#include "server/transport/tls_identity.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/certificates.h"

namespace cagefit::server {
namespace {

using cagefit::testing::CertificateAndKey;
using cagefit::testing::CertificateAuthority;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

class TlsIdentityTest : public ::testing::Test {
 protected:
  const TlsPaths paths_ = {"/cert", "/key", "/roots"};
  CertificateAuthority authority_{"authority"};
  const CertificateAndKey server_ = authority_.Issue("server");
};

TEST_F(TlsIdentityTest, WhatBelongsTogetherPasses) {
  const auto identity =
      ParseTlsIdentity(paths_, {server_.certificate, server_.key, authority_.certificate()});
  ASSERT_TRUE(identity.ok()) << identity.status();
  EXPECT_EQ(identity->certificates, server_.certificate);
  EXPECT_EQ(identity->key, server_.key);
  EXPECT_EQ(identity->client_roots, authority_.certificate());
  EXPECT_TRUE(ParseTlsIdentity({"/cert", "/key", ""}, {server_.certificate, server_.key}).ok());
}

TEST_F(TlsIdentityTest, TheFileThatIsWrongIsNamedAndNotQuoted) {
  const CertificateAndKey other = authority_.Issue("other");
  const std::string& roots = authority_.certificate();
  const std::string half = server_.certificate.substr(0, server_.certificate.size() / 2);
  const std::vector<std::pair<std::vector<std::string>, std::string>> bad = {
      {{"", server_.key, roots}, "/cert: holds no certificate"},
      {{half, server_.key, roots}, "/cert: holds no certificate"},
      {{server_.key, server_.key, roots}, "/cert: holds no certificate"},
      {{server_.certificate, "", roots}, "/key: holds no key"},
      {{server_.certificate, server_.certificate, roots}, "/key: holds no key"},
      {{server_.certificate, cagefit::testing::KeyUnderPassword(), roots}, "/key: holds no key"},
      {{server_.certificate, other.key, roots}, "/key: is not the key of the certificate in /cert"},
      {{server_.certificate, server_.key, "text"}, "/roots: holds no certificate"}};
  for (const auto& [contents, what] : bad) {
    const absl::Status status = ParseTlsIdentity(paths_, contents).status();
    EXPECT_TRUE(absl::IsInvalidArgument(status)) << status;
    EXPECT_THAT(std::string(status.message()), AllOf(HasSubstr(what), Not(HasSubstr("BEGIN"))));
  }
}

}  // namespace
}  // namespace cagefit::server
