#include "client/fit_client.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "server/session/private_folder.h"

namespace cagefit::client {
namespace {

TEST(FitClientTest, NamesAnAddressWhereNobodyAnswers) {
  const auto folder = server::PrivateFolder::Create();
  ASSERT_TRUE(folder.ok()) << folder.status();
  const std::string address = "unix:" + folder->path() + "/nobody";
  const auto client = FitClient::Connect({address, absl::Milliseconds(50)});
  EXPECT_TRUE(absl::IsUnavailable(client.status())) << client.status();
  EXPECT_THAT(std::string(client.status().message()), ::testing::HasSubstr(address));
}

}  // namespace
}  // namespace cagefit::client
