#include "server/server_options_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

namespace cagefit::server {
namespace {

using ::testing::HasSubstr;

TEST(SettingsFileTest, HasOneSettingALine) {
  const auto settings = ParseSettings(
      "# comment\n\n  max-points = 100  \r\nlisten=a:1 # why\npath=/a#b\nquoted=\"# \\\"\\n\" # q\n"
      "empty=\nlast==x");
  ASSERT_TRUE(settings.ok()) << settings.status();
  const std::vector<FileSetting> expected = {{"max-points", "100", 3}, {"listen", "a:1", 4},
                                             {"path", "/a#b", 5},      {"quoted", "# \"\n", 6},
                                             {"empty", "", 7},         {"last", "=x", 8}};
  ASSERT_EQ(settings->size(), expected.size());
  for (size_t k = 0; k < expected.size(); ++k) {
    EXPECT_EQ((*settings)[k].name, expected[k].name);
    EXPECT_EQ((*settings)[k].value, expected[k].value);
    EXPECT_EQ((*settings)[k].line, expected[k].line);
  }
}

TEST(SettingsFileTest, NamesTheLineThatIsWrong) {
  for (const char* bad :
       {"name", "=x", "[section]", "a=\"open", "a=\"open\\\"", "a=\"x\" y", "a=\"\\q\""}) {
    const auto settings = ParseSettings(std::string("a=1\n") + bad + "\n");
    EXPECT_TRUE(absl::IsInvalidArgument(settings.status())) << bad;
    EXPECT_THAT(std::string(settings.status().message()), HasSubstr("line 2: ")) << bad;
  }
}

TEST(SettingsFileTest, ReadsBackWhateverItWrites) {
  std::mt19937 random(3);
  const std::string alphabet("ab #\"\\=\n\r\t;,'\0\xc3\xa4\x7f[]", 19);
  for (int k = 0; k < 20'000; ++k) {
    std::string value;
    for (size_t size = random() % 8; size > 0; --size)
      value += alphabet[random() % alphabet.size()];
    const auto settings = ParseSettings("x=1\n" + SettingLine("name", value) + "\ny=2\n");
    ASSERT_TRUE(settings.ok()) << settings.status();
    ASSERT_EQ(settings->size(), 3u);
    ASSERT_EQ((*settings)[1].value, value);
  }
}

TEST(SettingsFileTest, ValuesWithoutSurprisesStayAsTheyAre) {
  EXPECT_EQ(SettingLine("listen", "[::1]:50051"), "listen=[::1]:50051");
  EXPECT_EQ(SettingLine("path", "/a b/c#d"), "path=/a b/c#d");
}

}  // namespace
}  // namespace cagefit::server
