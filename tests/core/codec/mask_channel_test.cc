#include "core/codec/mask_channel.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace cagefit {
namespace {

using ::testing::ElementsAre;
using ::testing::FloatEq;

// One row of pixels of 8 bits.
std::vector<float> Mask(int channels, const std::vector<uint8_t>& bytes) {
  return MaskChannel({static_cast<int>(bytes.size()) / channels, 1, channels, 1, bytes}).values;
}

TEST(MaskChannelTest, KeepsGrayToTheBit) {
  EXPECT_THAT(Mask(1, {0, 128, 255}), ElementsAre(0.0f, 128 / 255.0f, 1.0f));
  EXPECT_THAT(MaskChannel({2, 1, 1, 2, {1, 2, 255, 255}}).values,
              ElementsAre(FloatEq(258 / 65535.0f), 1.0f));
}

TEST(MaskChannelTest, WhiteIsNeverAboveOne) {
  EXPECT_THAT(Mask(3, {255, 255, 255, 0, 0, 0}), ElementsAre(1.0f, 0.0f));
}

TEST(MaskChannelTest, IgnoresAlphaThatDoesNotVary) {
  EXPECT_THAT(Mask(2, {0, 255, 51, 255}), ElementsAre(0.0f, FloatEq(0.2f)));
  EXPECT_THAT(Mask(2, {51, 255, 51, 255}), ElementsAre(FloatEq(0.2f), FloatEq(0.2f)));
  EXPECT_THAT(Mask(4, {0, 0, 0, 0, 255, 255, 255, 0}), ElementsAre(0.0f, 1.0f));
}

TEST(MaskChannelTest, TakesTheAlphaOfACutOutInOneColor) {
  EXPECT_THAT(Mask(2, {0, 0, 0, 51, 0, 255}), ElementsAre(0.0f, FloatEq(0.2f), 1.0f));
  // What is invisible may have any colour: here black on white that nobody sees.
  EXPECT_THAT(Mask(4, {255, 255, 255, 0, 0, 0, 0, 51, 0, 0, 0, 255}),
              ElementsAre(0.0f, FloatEq(0.2f), 1.0f));
}

TEST(MaskChannelTest, TakesTheLuminanceWhereColorAndAlphaVary) {
  EXPECT_THAT(Mask(4, {255, 0, 0, 100, 0, 0, 255, 255}),
              ElementsAre(FloatEq(0.2126f), FloatEq(0.0722f)));
}

}  // namespace
}  // namespace cagefit
