#include "server/transport/incoming_blob.h"

#include <gtest/gtest.h>

#include "server/session/error_detail.h"

namespace cagefit::server {
namespace {

class IncomingBlobTest : public ::testing::Test {
 protected:
  void ExpectRefused(const absl::Status& status, const std::string& field) {
    ASSERT_TRUE(DetailOf(status).has_value()) << status;
    EXPECT_EQ(DetailOf(status)->field, field) << status;
    EXPECT_EQ(absl::IsResourceExhausted(status), DetailOf(status)->reason == "LIMIT_EXCEEDED");
  }

  MemoryAccount budget_{"bytes in flight of all calls", 1000};
};

TEST_F(IncomingBlobTest, PutsChunksTogetherAndHoldsTheirShareOfTheBudget) {
  {
    IncomingBlob blob(100, &budget_);
    EXPECT_FALSE(blob.CheckComplete().ok());
    ASSERT_TRUE(blob.Add(5, "abc").ok());
    EXPECT_FALSE(blob.CheckComplete().ok());
    ASSERT_TRUE(blob.Add(5, "de").ok());
    EXPECT_EQ(blob.CheckComplete(), absl::OkStatus());
    EXPECT_EQ(blob.TakeBytes(), "abcde");
    EXPECT_EQ(budget_.taken(), 5);
  }
  EXPECT_EQ(budget_.taken(), 0);
}

TEST_F(IncomingBlobTest, RefusesWhatDoesNotFit) {
  IncomingBlob blob(100, &budget_);
  ExpectRefused(blob.Add(101, "abc"), "total_bytes");
  ExpectRefused(blob.Add(5, ""), "data");
  ASSERT_TRUE(blob.Add(5, "abc").ok());
  ExpectRefused(blob.Add(6, "de"), "total_bytes");
  ExpectRefused(blob.Add(5, "def"), "data");
  IncomingBlob large(2000, &budget_);
  ExpectRefused(large.Add(1500, std::string(1500, 'x')), "bytes in flight of all calls");
}

}  // namespace
}  // namespace cagefit::server
