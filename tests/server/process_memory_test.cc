#include "server/process_memory.h"

#include <gtest/gtest.h>

#include <cstring>
#include <memory>
#include <vector>

#include "absl/time/clock.h"
#include "tests/server/running_server.h"
#include "tests/support/sanitizer.h"

namespace cagefit::server {
namespace {

constexpr int64_t kBlockBytes = 64 << 10, kMib = 1 << 20;

// Used blocks, each behind one that was freed: as much again that the allocator cannot cut off at
// an end.
std::vector<std::unique_ptr<char[]>> SpreadBlocks(int64_t bytes = 64 * kMib) {
  std::vector<std::unique_ptr<char[]>> used, freed;
  for (int64_t k = 0; k < bytes / kBlockBytes; ++k) {
    for (auto* blocks : {&freed, &used}) {
      blocks->push_back(std::make_unique<char[]>(kBlockBytes));
      std::memset(blocks->back().get(), 1, kBlockBytes);
    }
  }
  return used;
}

class ResidentLimitTest : public ::testing::Test {
 protected:
  void SetUp() override {
    if (cagefit::testing::kIsSanitized) GTEST_SKIP() << "a sanitizer has its own allocator";
  }
};

TEST_F(ResidentLimitTest, GivesFreedBlocksBackBeforeMoreIsAllocatedThanThereIsRoomFor) {
  const auto used = SpreadBlocks();
  const int64_t before = ResidentBytes();
  ResidentLimit limit(before + 1'000'000'000);
  EXPECT_FALSE(limit.MakeRoom(900'000'000));
  EXPECT_GT(ResidentBytes(), before - 64 * kMib / 10);
  EXPECT_TRUE(limit.MakeRoom(1'000'000'001));
  EXPECT_LT(ResidentBytes(), before - 64 * kMib * 9 / 10);
}

TEST_F(ResidentLimitTest, DoesNotTryAllTheTimeWhereAllIsUsed) {
  const auto used = SpreadBlocks();
  ResidentLimit limit(0);
  absl::Duration trying;
  const absl::Time start = absl::Now();
  absl::Time now = start;
  while (now < start + absl::Milliseconds(200)) {
    const absl::Time before = now;
    const bool has_tried = limit.MakeRoom(1);
    now = absl::Now();
    if (has_tried) trying += now - before;
  }
  EXPECT_GT(trying, absl::ZeroDuration());
  EXPECT_LT(trying, 0.3 * (now - start));
}

TEST_F(ResidentLimitTest, IsKeptByAServerThatIsAskedForMore) {
  ServerOptions options;
  options.max_memory_mib = 256;
  const testing::RunningServer server(options);
  const auto used = SpreadBlocks(128 * kMib);
  ASSERT_GT(ResidentBytes(), 256 * kMib);
  EXPECT_TRUE(server.Connect()->CreateSession(testing::CageRequest()).ok());
  EXPECT_LT(ResidentBytes(), 256 * kMib);
}

}  // namespace
}  // namespace cagefit::server
