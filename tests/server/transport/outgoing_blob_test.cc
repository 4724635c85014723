#include "server/transport/outgoing_blob.h"

#include <gtest/gtest.h>

namespace cagefit::server {
namespace {

TEST(OutgoingBlobTest, GoesInChunksOfAtMostAMebibyteThatTellTheTotal) {
  MemoryAccount budget("bytes in flight of all calls", 4 << 20);
  {
    OutgoingBlob blob(&budget);
    std::string whole((5 << 19) + 7, 'x');
    whole.back() = 'y';
    ASSERT_TRUE(blob.Set(whole).ok());
    EXPECT_EQ(budget.taken(), static_cast<int64_t>(whole.size()));
    std::string sent;
    int chunks = 0;
    do {
      const v1::DataChunk* chunk = blob.Next();
      EXPECT_EQ(chunk->total_bytes(), whole.size());
      EXPECT_LE(chunk->data().size(), size_t{1} << 20);
      sent += chunk->data();
      ++chunks;
    } while (!blob.is_sent());
    EXPECT_EQ(chunks, 3);
    EXPECT_TRUE(sent == whole);
  }
  EXPECT_EQ(budget.taken(), 0);
}

TEST(OutgoingBlobTest, AnEmptyResultIsOneChunk) {
  MemoryAccount budget("in flight", 10);
  OutgoingBlob blob(&budget);
  ASSERT_TRUE(blob.Set("").ok());
  EXPECT_EQ(blob.Next()->total_bytes(), 0u);
  EXPECT_TRUE(blob.is_sent());
}

TEST(OutgoingBlobTest, NeedsRoomInTheBudget) {
  MemoryAccount budget("in flight", 10);
  OutgoingBlob blob(&budget);
  EXPECT_TRUE(absl::IsResourceExhausted(blob.Set("eleven char")));
}

}  // namespace
}  // namespace cagefit::server
