#include "client/io/image_file.h"

#include <cmath>
#include <cstring>

#include "client/io/file_bytes.h"
#include "tests/client/io/expect_error.h"
#include "tests/support/temp_folder.h"

namespace cagefit::client {
namespace {

using ::testing::ElementsAre;
using ::testing::StartsWith;

std::string TempFile(const std::string& name) { return cagefit::testing::TempFolder() + name; }

TEST(ImageFileTest, ReadsTheMaskThatItWrote) {
  const std::string path = TempFile("image_file.png");
  Image image(2, 1);
  image.values = {0.25f, 1};
  ASSERT_TRUE(WritePng(path, image, 16).ok());
  const auto mask = ReadMask(path);
  ASSERT_TRUE(mask.ok()) << mask.status();
  EXPECT_NEAR(mask->values[0], 0.25, 0.51 / 65535);
  EXPECT_EQ(mask->values[1], 1);
}

TEST(ImageFileTest, WritesFloatMapsFromTheBottomUp) {
  const std::string path = TempFile("image_file.pfm");
  Image image(2, 2);
  image.values = {1, 2, -3e-20f, INFINITY};
  ASSERT_TRUE(WritePfm(path, image).ok());
  const std::string bytes = *ReadFileBytes(path, 1000);
  const std::string head = "Pf\n2 2\n-1.0\n";
  ASSERT_EQ(bytes.size(), head.size() + 16);
  EXPECT_EQ(bytes.substr(0, head.size()), head);
  std::vector<float> values(4);
  std::memcpy(values.data(), bytes.data() + head.size(), 16);
  EXPECT_THAT(values, ElementsAre(-3e-20f, INFINITY, 1, 2));
  EXPECT_EQ(bytes.substr(head.size() + 8, 4), std::string("\0\0\x80\x3f", 4));  // 1, low byte first
}

TEST(ImageFileTest, WritesFloatMapsOfThreeChannels) {
  const std::string path = TempFile("image_file_color.pfm");
  Image image(1, 2, 3);
  image.values = {1, 2, 3, 4, 5, 6};
  ASSERT_TRUE(WritePfm(path, image).ok());
  const std::string bytes = *ReadFileBytes(path, 1000);
  EXPECT_THAT(bytes, StartsWith("PF\n1 2\n-1.0\n"));
  std::vector<float> values(6);
  std::memcpy(values.data(), bytes.data() + bytes.size() - 24, 24);
  EXPECT_THAT(values, ElementsAre(4, 5, 6, 1, 2, 3));
}

TEST(ImageFileTest, ErrorsNameThePath) {
  EXPECT_EQ(ReadMask("/nowhere/mask.png").status().code(), absl::StatusCode::kNotFound);
  const std::string path = TempFile("image_file_broken.png");
  ASSERT_TRUE(WriteFileBytes(path, "no picture").ok());
  EXPECT_INVALID(ReadMask(path), path + ": PNG: Not a PNG");
  ASSERT_TRUE(WritePng(path, Image(20, 3), 8).ok());
  const absl::Status large = ReadMask(path, {10, 10, 100}).status();
  EXPECT_EQ(large.code(), absl::StatusCode::kResourceExhausted);
  EXPECT_THAT(std::string(large.message()), StartsWith(path + ": PNG: its width is 20"));
  EXPECT_THAT(std::string(WritePng(path, Image(2, 2, 2), 8).message()), StartsWith(path));
  EXPECT_THAT(std::string(WritePfm(path, Image(2, 2, 2)).message()), StartsWith(path));
  EXPECT_THAT(std::string(WritePfm("/nowhere/x.pfm", Image(2, 2)).message()),
              StartsWith("/nowhere/x.pfm: cannot be written"));
}

}  // namespace
}  // namespace cagefit::client
