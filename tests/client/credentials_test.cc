#include "client/credentials.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace cagefit::client {
namespace {

using ::testing::HasSubstr;

TEST(ClientCredentialsTest, LoopbackAndUnixSocketsStayOnThisMachine) {
  for (const char* address : {"unix:/run/cagefit", "unix-abstract:cagefit", "localhost:50051",
                              "127.0.0.1:50051", "127.8.9.10:1", "[::1]:50051"}) {
    EXPECT_TRUE(StaysOnThisMachine(address)) << address;
  }
  for (const char* address :
       {"rig:50051", "10.0.0.1:50051", "128.0.0.1:1", "127.example.com:50051",
        "localhost.example.com:50051", "[::2]:50051", "[::]:50051", "0.0.0.0:1",
        "dns:///localhost:50051", "ipv4:127.0.0.1:50051,10.0.0.1:50051", "unixes:50051", ""}) {
    EXPECT_FALSE(StaysOnThisMachine(address)) << address;
  }
}

TEST(ClientCredentialsTest, ATokenGoesToAnotherMachineOnlyEncryptedOrWhereItIsAskedFor) {
  ClientCredentials credentials;
  credentials.token_file = "/token";
  EXPECT_EQ(credentials.Check("localhost:1"), absl::OkStatus());
  const absl::Status refused = credentials.Check("rig:1");
  EXPECT_TRUE(absl::IsInvalidArgument(refused)) << refused;
  EXPECT_THAT(std::string(refused.message()), HasSubstr("rig:1"));
  ClientCredentials tls = credentials, roots = credentials, plain = credentials;
  tls.tls = true;
  roots.ca_file = "/ca";
  plain.plain_token = true;
  for (const ClientCredentials& good : {tls, roots, plain}) {
    EXPECT_EQ(good.Check("rig:1"), absl::OkStatus());
  }
  credentials.token_file.clear();
  EXPECT_EQ(credentials.Check("rig:1"), absl::OkStatus());
}

TEST(ClientCredentialsTest, HalfOfACertificateIsAnError) {
  ClientCredentials certificate, key;
  certificate.cert_file = "/cert";
  key.key_file = "/key";
  EXPECT_THAT(std::string(certificate.Check("rig:1").message()), HasSubstr("--tls-key"));
  EXPECT_THAT(std::string(key.Check("rig:1").message()), HasSubstr("--tls-cert"));
}

}  // namespace
}  // namespace cagefit::client
