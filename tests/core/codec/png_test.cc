#include "core/codec/png.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <utility>
#include <vector>

#include "tests/core/codec/png_samples.h"
#include "tests/support/spoiled_bytes.h"

namespace cagefit {
namespace {

using ::testing::ElementsAre;
using ::testing::Eq;
using ::testing::FloatEq;
using ::testing::FloatNear;
using ::testing::HasSubstr;
using testing::PngBytes;
using testing::PngHeader;
using testing::PngSample;

// 13 x 9 so that every interlacing pass has pixels and none ends with a whole byte.
PngSample Sample(int bits, bool interlaced) {
  PngSample png;
  png.width = 13;
  png.height = 9;
  png.bits = bits;
  png.interlaced = interlaced;
  for (int k = 0; k < 13 * 9; ++k) png.samples.push_back(k * 7919 % (1 << bits));
  return png;
}

PngSample Row(uint32_t width, int bits, testing::PngColor color, std::vector<int> samples) {
  PngSample png;
  png.width = width;
  png.bits = bits;
  png.color = color;
  png.samples = std::move(samples);
  return png;
}

Image Decoded(const PngSample& png) {
  const auto image = DecodePng(PngBytes(png), {});
  EXPECT_TRUE(image.ok()) << image.status();
  return image.value_or(Image());
}

std::string Error(const std::string& bytes, const PngLimits& limits, absl::StatusCode code) {
  const absl::Status status = DecodePng(bytes, limits).status();
  EXPECT_EQ(status.code(), code) << status;
  return std::string(status.message());
}

TEST(PngTest, ReadsGrayOfEveryDepthInterlacedOrNot) {
  for (const int bits : {1, 2, 4, 8, 16}) {
    for (const bool interlaced : {false, true}) {
      const PngSample png = Sample(bits, interlaced);
      const Image image = Decoded(png);
      ASSERT_EQ(image.width, 13);
      ASSERT_EQ(image.height, 9);
      ASSERT_EQ(image.channels, 1);
      for (size_t k = 0; k < png.samples.size(); ++k) {
        const double value = static_cast<double>(png.samples[k]) / ((1 << bits) - 1);
        ASSERT_THAT(image.values[k], FloatEq(static_cast<float>(value)))
            << bits << " bits, interlaced " << interlaced << ", pixel " << k;
      }
    }
  }
}

TEST(PngTest, ReadsColorAsLuminance) {
  PngSample png = Row(3, 8, testing::kRgb, {255, 0, 0, 0, 255, 0, 0, 0, 255});
  EXPECT_THAT(Decoded(png).values,
              ElementsAre(FloatEq(0.2126f), FloatEq(0.7152f), FloatEq(0.0722f)));
  PngSample deep = Row(2, 16, testing::kRgb, {256, 256, 256, 65535, 65535, 65535});
  EXPECT_THAT(Decoded(deep).values, ElementsAre(FloatEq(256.0f / 65535), FloatEq(1)));
}

TEST(PngTest, ReadsPalettesAndTheirTransparency) {
  PngSample png = Row(4, 2, testing::kPalette, {2, 0, 1, 1});
  png.palette = std::string("\0\0\0\xff\xff\xff\x33\x33\x33", 9);
  EXPECT_THAT(Decoded(png).values, ElementsAre(FloatEq(0.2f), Eq(0), Eq(1), Eq(1)));
  png.palette = "zzzzzzzzz";  // one colour: only the alpha says what is there
  png.transparency = std::string("\0\xff\x33", 3);
  EXPECT_THAT(Decoded(png).values, ElementsAre(FloatEq(0.2f), Eq(0), Eq(1), Eq(1)));
}

TEST(PngTest, ReadsAlphaBesideTheColor) {
  PngSample gray = Row(2, 8, testing::kGrayAlpha, {0, 51, 0, 255});
  EXPECT_THAT(Decoded(gray).values, ElementsAre(FloatEq(0.2f), Eq(1)));
  PngSample rgba = Row(2, 16, testing::kRgba, {9, 8, 7, 13107, 9, 8, 7, 65535});
  EXPECT_THAT(Decoded(rgba).values, ElementsAre(FloatEq(0.2f), Eq(1)));
}

TEST(PngTest, ReadsWhatItWrote) {
  Image image(3, 2);
  image.values = {0, 0.25f, 0.5f, 0.75f, 1, 1.0f / 3};
  for (const auto& [bits, step] : {std::pair(8, 0.5f / 255), std::pair(16, 0.5f / 65535)}) {
    const auto bytes = EncodePng(image, bits);
    ASSERT_TRUE(bytes.ok()) << bytes.status();
    const auto read = DecodePng(*bytes, {});
    ASSERT_TRUE(read.ok()) << read.status();
    ASSERT_EQ(read->width, 3);
    for (size_t k = 0; k < image.values.size(); ++k) {
      EXPECT_THAT(read->values[k], FloatNear(image.values[k], 1.001f * step)) << bits;
    }
  }
}

TEST(PngTest, WritesColorInItsOrder) {
  Image image(2, 1, 3);
  image.values = {1, 0, 0, 0, 0, 1};
  const auto read = DecodePng(*EncodePng(image, 8), {});
  ASSERT_TRUE(read.ok()) << read.status();
  EXPECT_THAT(read->values, ElementsAre(FloatEq(0.2126f), FloatEq(0.0722f)));
}

TEST(PngTest, ClampsWhatIsOutOfRange) {
  Image image(4, 1);
  image.values = {-1, 2, NAN, INFINITY};
  for (const int bits : {8, 16}) {
    EXPECT_THAT(DecodePng(*EncodePng(image, bits), {})->values, ElementsAre(0, 1, 0, 1));
  }
}

TEST(PngTest, RefusesToWriteWhatIsNoGrayOrColorImage) {
  EXPECT_THAT(std::string(EncodePng(Image(2, 2, 2), 8).status().message()),
              HasSubstr("2 channels; expected 1 or 3"));
  EXPECT_THAT(std::string(EncodePng(Image(2, 2), 12).status().message()), HasSubstr("bits is 12"));
  EXPECT_THAT(std::string(EncodePng(Image(), 8).status().message()), HasSubstr("no pixels"));
}

TEST(PngTest, HoldsTheHeaderAgainstTheLimits) {
  constexpr auto kExhausted = absl::StatusCode::kResourceExhausted;
  const PngLimits limits{100, 50, 3000};
  EXPECT_THAT(Error(PngHeader(101, 1), limits, kExhausted),
              HasSubstr("width is 101; the limit is 100"));
  EXPECT_THAT(Error(PngHeader(1, 51), limits, kExhausted),
              HasSubstr("height is 51; the limit is 50"));
  EXPECT_THAT(Error(PngHeader(100, 31), limits, kExhausted),
              HasSubstr("number of pixels is 3100; the limit is 3000"));
  EXPECT_THAT(Error(PngHeader(0x7fffffff, 0x7fffffff), {}, kExhausted), HasSubstr("2147483647"));
  EXPECT_TRUE(DecodePng(PngBytes(Sample(8, false)), {13, 9, 117}).ok());
}

TEST(PngTest, RefusesAClaimThatItsBytesCannotHold) {
  EXPECT_THAT(Error(PngHeader(8000, 8000), {}, absl::StatusCode::kInvalidArgument),
              HasSubstr("claims 8000 x 8000 pixels, more than"));
  // Zeros deflate as far as anything does.
  EXPECT_TRUE(DecodePng(*EncodePng(Image(4000, 2000), 8), {}).ok());
}

TEST(PngTest, SaysWhatIsWrong) {
  constexpr auto kInvalid = absl::StatusCode::kInvalidArgument;
  const std::string good = PngBytes(Sample(8, false));
  EXPECT_THAT(Error("", {}, kInvalid), HasSubstr("end early"));
  EXPECT_THAT(Error("P5 13 9 255 and so on", {}, kInvalid), HasSubstr("Not a PNG"));
  EXPECT_THAT(Error(good.substr(0, good.size() - 20), {}, kInvalid), HasSubstr("end early"));
  std::string flipped = good;
  flipped[19] ^= 1;  // of the width
  EXPECT_THAT(Error(flipped, {}, kInvalid), HasSubstr("CRC"));
}

TEST(PngTest, SurvivesEveryTruncation) {
  for (const bool interlaced : {false, true}) {
    testing::ForEachTruncation(PngBytes(Sample(16, interlaced)), [](const std::string& bytes) {
      EXPECT_EQ(DecodePng(bytes, {}).status().code(), absl::StatusCode::kInvalidArgument)
          << bytes.size();
    });
  }
}

TEST(PngTest, SurvivesFlippedBytes) {
  const auto survives = [](const std::string& bytes) {
    const auto image = DecodePng(bytes, {1000, 1000, 100'000});
    if (image.ok()) {
      EXPECT_EQ(image->values.size(), image->width * image->height);
    }
  };
  testing::ForEachFlip(PngBytes(Sample(4, true)), 5000, 1, survives);
  testing::ForEachFlip(*EncodePng(Image(20, 10, 3, 0.4f), 8), 5000, 2, survives);
}

// Checksums catch nearly all flips; made good, they let them through to what lies behind.
TEST(PngTest, SurvivesFlippedBytesBehindTheChecksums) {
  const auto survives = [](const std::string& bytes) {
    const auto image = DecodePng(testing::WithGoodChecksums(bytes), {1000, 1000, 100'000});
    if (image.ok()) {
      EXPECT_EQ(image->values.size(), image->width * image->height);
    }
  };
  PngSample palette = Sample(4, true);
  palette.color = testing::kPalette;
  palette.palette = std::string(3 * 16, 'p');
  palette.transparency = "t";
  testing::ForEachFlip(PngBytes(palette), 5000, 3, survives);
  testing::ForEachFlip(*EncodePng(Image(20, 10, 3, 0.4f), 8), 5000, 4, survives);
}

}  // namespace
}  // namespace cagefit
