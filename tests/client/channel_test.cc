#include "client/channel.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "core/base/private_folder.h"

namespace cagefit::client {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

class ChannelTest : public ::testing::Test {
 protected:
  std::string Write(const std::string& name, const std::string& text) {
    std::ofstream(folder_.path() + "/" + name) << text;
    return folder_.path() + "/" + name;
  }
  static absl::Status Open(const ClientCredentials& credentials) {
    return OpenChannel("localhost:1", credentials, grpc::ChannelArguments()).status();
  }

  PrivateFolder folder_ = PrivateFolder::Create().value();
};

TEST_F(ChannelTest, ATokenFileHoldsATokenAlone) {
  ClientCredentials credentials;
  for (const std::string& good : {"cft_A-b_9", "cft_x\n", "  cft_x\r\n"}) {
    credentials.token_file = Write("token", good);
    EXPECT_EQ(Open(credentials), absl::OkStatus()) << good;
  }
  for (const std::string& bad :
       {std::string(), std::string("\n"), std::string("secret two"), std::string("secret\nsecret"),
        std::string("secret\x01"), std::string("secret\xc3\xa4"), std::string(257, 's')}) {
    credentials.token_file = Write("token", bad);
    const absl::Status status = Open(credentials);
    EXPECT_TRUE(absl::IsInvalidArgument(status)) << status;
    EXPECT_THAT(std::string(status.message()),
                AllOf(HasSubstr(credentials.token_file), Not(HasSubstr("secret"))));
  }
}

TEST_F(ChannelTest, FilesThatCannotBeReadAreNamed) {
  ClientCredentials token, roots;
  token.token_file = "/nowhere/token";
  roots.ca_file = "/nowhere/ca";
  EXPECT_THAT(std::string(Open(token).message()),
              HasSubstr("/nowhere/token: cannot be read: No such file"));
  EXPECT_THAT(std::string(Open(roots).message()),
              HasSubstr("/nowhere/ca: cannot be read: No such file"));
}

TEST_F(ChannelTest, FilesThatHoldSomethingElseAreNamed) {
  ClientCredentials credentials;
  credentials.ca_file = Write("ca", "secret");
  EXPECT_THAT(std::string(Open(credentials).message()),
              AllOf(HasSubstr(credentials.ca_file + ": holds no certificate in PEM format"),
                    Not(HasSubstr("secret"))));
}

TEST_F(ChannelTest, ATokenForAnotherMachineIsRefusedBeforeItIsSent) {
  ClientCredentials credentials;
  credentials.token_file = Write("token", "cft_x");
  EXPECT_TRUE(absl::IsInvalidArgument(
      OpenChannel("rig:1", credentials, grpc::ChannelArguments()).status()));
}

}  // namespace
}  // namespace cagefit::client
