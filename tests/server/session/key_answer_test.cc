#include "server/session/key_answer.h"

#include <gtest/gtest.h>

#include "tests/server/session/session_fixture.h"

namespace cagefit::server {
namespace {

using testing::CageConfig;
using testing::DecodedFrame;
using testing::MovingFrame;
using testing::OpenSession;

TEST(KeyAnswerTest, HoldsTheWholeStateWhereTheStoredOneHoldsADifference) {
  OpenSession open(CageConfig());
  for (uint64_t number = 0; number < 3; ++number) {
    ASSERT_TRUE(open.Answer(MovingFrame(number)).ok());
  }
  const auto stored = *open.ledger->Find(2);
  ASSERT_FALSE(stored->delta.key);
  const auto keyed = KeyAnswer(*open.ledger, stored);
  ASSERT_TRUE(keyed.ok()) << keyed.status();
  EXPECT_TRUE((*keyed)->delta.key);
  EXPECT_EQ((*keyed)->delta.checksum, stored->delta.checksum);
  EXPECT_EQ((*keyed)->sequence_number, 2u);
  GridPoints q;
  ASSERT_TRUE(ApplyDelta(*Decode((*keyed)->delta, 42), &q).ok());
  EXPECT_EQ(Dequantize(q, stored->delta.grid), open.Vertices(2));
}

TEST(KeyAnswerTest, LeavesARejectionAndPositionsAsTheyAre) {
  SessionConfig config = CageConfig();
  config.quantum = 0;
  OpenSession open(config);
  ASSERT_TRUE(open.Answer(MovingFrame(0)).ok());
  ASSERT_TRUE(open.Answer(DecodedFrame(1, "not Draco")).ok());
  for (const uint64_t number : {0, 1}) {
    const auto stored = *open.ledger->Find(number);
    EXPECT_EQ(*KeyAnswer(*open.ledger, stored), stored) << number;
  }
}

}  // namespace
}  // namespace cagefit::server
