#include "client/report/shown_frames.h"

#include <gmock/gmock.h>

namespace cagefit::client {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::SizeIs;

TEST(ShownFramesTest, AreAllWhereThereAreFew) {
  EXPECT_THAT(ShownFrames({}, 4), IsEmpty());
  EXPECT_THAT(ShownFrames({1, 2, 3, 4}, 4), ElementsAre(0, 1, 2, 3));
}

TEST(ShownFramesTest, AreEveryKthAndTheWorst) {
  EXPECT_THAT(ShownFrames({1, 1, 1, 1, 1, 7, 1, 1}, 4), ElementsAre(0, 3, 5, 6));
}

TEST(ShownFramesTest, NeverExceedTheLimit) {
  for (size_t count = 1; count < 60; ++count) {
    for (size_t most = 2; most < 20; ++most) {
      std::vector<double> rms(count, 1);
      rms[count / 2] = 2;
      const std::vector<size_t> shown = ShownFrames(rms, most);
      EXPECT_LE(shown.size(), most) << count;
      EXPECT_THAT(shown, Contains(count / 2));
      EXPECT_THAT(shown, Contains(0u));
    }
  }
  EXPECT_THAT(ShownFrames(std::vector<double>(1000, 1), 101), SizeIs(100));
}

}  // namespace
}  // namespace cagefit::client
