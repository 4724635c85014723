#include "server/process_memory.h"

#include <gtest/gtest.h>

#include <cstring>
#include <memory>
#include <vector>

#include "absl/time/clock.h"
#include "tests/support/sanitizer.h"

namespace cagefit::server {
namespace {

constexpr int64_t kBlockBytes = 64 << 10, kBlocks = 1024;

// Used blocks, each behind one that was freed: 64 MiB that the allocator cannot cut off at an end.
std::vector<std::unique_ptr<char[]>> SpreadBlocks() {
  std::vector<std::unique_ptr<char[]>> used, freed;
  for (int64_t k = 0; k < kBlocks; ++k) {
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
    if (testing::kIsSanitized) GTEST_SKIP() << "a sanitizer has its own allocator";
  }
};

TEST_F(ResidentLimitTest, GivesFreedBlocksBackBeforeMoreIsAllocatedThanThereIsRoomFor) {
  const auto used = SpreadBlocks();
  const int64_t before = ResidentBytes();
  ResidentLimit limit(before + 1'000'000'000);
  EXPECT_FALSE(limit.MakeRoom(900'000'000));
  EXPECT_GT(ResidentBytes(), before - kBlockBytes * kBlocks / 10);
  EXPECT_TRUE(limit.MakeRoom(1'000'000'001));
  EXPECT_LT(ResidentBytes(), before - kBlockBytes * kBlocks * 9 / 10);
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

}  // namespace
}  // namespace cagefit::server
