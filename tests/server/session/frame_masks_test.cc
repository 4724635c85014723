#include "server/session/frame_masks.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/server/session/session_fixture.h"
#include "tests/support/masks.h"

namespace cagefit::server {
namespace {

using cagefit::testing::MaskPng;
using cagefit::testing::SmallCamera;
using ::testing::HasSubstr;
using testing::ReasonOf;

std::vector<Camera> Cameras() { return {SmallCamera("left"), SmallCamera("right")}; }

void ExpectRefused(const absl::Status& status, const std::string& field, const std::string& text) {
  EXPECT_TRUE(absl::IsInvalidArgument(status)) << status;
  ASSERT_TRUE(DetailOf(status).has_value()) << status;
  EXPECT_EQ(DetailOf(status)->field, field);
  EXPECT_THAT(std::string(status.message()), HasSubstr(text));
}

TEST(MaskBytesTest, AddsUpWithinTheFrame) {
  EXPECT_EQ(*MaskBytes("masks", {}, 0), 0u);
  EXPECT_EQ(*MaskBytes("masks", {{"a", 3}, {"b", 4}}, 7), 7u);
  ExpectRefused(MaskBytes("masks", {{"a", 3}, {"b", 5}}, 7).status(), "masks[1].png_bytes",
                "masks[1].png_bytes is 5; of the frame's 7 bytes 4 are left");
  ExpectRefused(MaskBytes("masks", {{"a", 3}, {"b", ~uint64_t{0}}}, 7).status(),
                "masks[1].png_bytes", "18446744073709551615");
  ExpectRefused(MaskBytes("masks", {{"a", 0}}, 7).status(), "masks[0].png_bytes", "is left out");
}

TEST(DecodedMaskBytesTest, CountsTheImagesThatAreKeptAndTheOneInWork) {
  std::vector<Camera> cameras = Cameras();
  cameras[1].width = 8;
  EXPECT_EQ(DecodedMaskBytes({}, cameras), 0);
  EXPECT_EQ(DecodedMaskBytes({{"left", 9}, {"left", 9}, {"front", 9}}, cameras), 12 * (4 + 8));
  EXPECT_EQ(DecodedMaskBytes({{"right", 9}, {"left", 9}}, cameras), 4 * (12 + 24) + 8 * 24);
}

TEST(DecodeMasksTest, GivesEveryCameraItsImage) {
  const std::string black = MaskPng(4, 3, 0), white = MaskPng(4, 3);
  const auto images = DecodeMasks("masks", white + black,
                                  {{"right", white.size()}, {"left", black.size()}}, Cameras());
  ASSERT_TRUE(images.ok()) << images.status();
  EXPECT_EQ((*images)[0].values, std::vector<float>(12, 0));
  EXPECT_EQ((*images)[1].values, std::vector<float>(12, 1));
}

TEST(DecodeMasksTest, NamesTheCameraThatIsUnknownOrComesTwice) {
  const std::string png = MaskPng(4, 3);
  ExpectRefused(DecodeMasks("masks", png, {{"front", png.size()}}, Cameras()).status(),
                "masks[0].camera", "is \"front\"; the session's cameras are \"left\", \"right\"");
  ExpectRefused(DecodeMasks("masks", png, {{"front", png.size()}}, {}).status(), "masks[0].camera",
                "the session has no cameras");
  ExpectRefused(
      DecodeMasks("masks", png + png, {{"left", png.size()}, {"left", png.size()}}, Cameras())
          .status(),
      "masks[1].camera", "\"left\"");
}

TEST(DecodeMasksTest, RefusesAnImageThatIsNotOfItsCamerasSize) {
  for (const auto& [width, height] : {std::pair(3, 4), std::pair(2, 3), std::pair(400, 300)}) {
    const std::string png = MaskPng(width, height);
    const absl::Status status =
        DecodeMasks("masks", png, {{"right", png.size()}}, Cameras()).status();
    ExpectRefused(status, "masks[0]", "\"right\"");
    EXPECT_THAT(std::string(status.message()), HasSubstr("4 x 3"));
  }
}

TEST(DecodeMasksTest, RefusesWhatIsNoPng) {
  const std::string png = MaskPng(4, 3);
  for (const std::string& bytes : {std::string("no PNG"), png.substr(0, 40), std::string(1, 'x')}) {
    const absl::Status status =
        DecodeMasks("masks", bytes, {{"left", bytes.size()}}, Cameras()).status();
    ExpectRefused(status, "masks[0]", "PNG");
    EXPECT_EQ(ReasonOf(status), "BAD_MASK");
    EXPECT_EQ(DetailOf(status)->value, "left");
  }
}

}  // namespace
}  // namespace cagefit::server
