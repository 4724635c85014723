#include "client/io/text_cursor.h"

#include <gmock/gmock.h>

#include <cmath>

namespace cagefit::client {
namespace {

using ::testing::ElementsAre;

std::vector<std::string> Lines(absl::string_view text) {
  TextCursor cursor(text);
  absl::string_view line;
  std::vector<std::string> lines;
  while (cursor.NextLine(&line)) lines.emplace_back(line);
  return lines;
}

TEST(TextCursorTest, LinesEndInAnyOfThreeWays) {
  EXPECT_THAT(Lines("a\nb\r\nc\rd"), ElementsAre("a", "b", "c", "d"));
  EXPECT_THAT(Lines("a\n\nb\n"), ElementsAre("a", "", "b"));
  EXPECT_TRUE(Lines("").empty());
}

TEST(TextCursorTest, WordsCrossLinesAndKnowTheirNumber) {
  TextCursor cursor("one\ttwo\r\n\r\n  three");
  EXPECT_EQ(cursor.NextWord(), "one");
  EXPECT_EQ(cursor.line(), 1);
  EXPECT_EQ(cursor.NextWord(), "two");
  EXPECT_EQ(cursor.NextWord(), "three");
  EXPECT_EQ(cursor.line(), 3);
  EXPECT_EQ(cursor.NextWord(), "");
}

TEST(TextCursorTest, SplitsAtSeparatorsAndEndsAtAComment) {
  std::vector<absl::string_view> words;
  SplitWords(" 1,2; 3 #4", ",;", '#', &words);
  EXPECT_THAT(words, ElementsAre("1", "2", "3"));
  SplitWords("# all of it", "", '#', &words);
  EXPECT_TRUE(words.empty());
}

TEST(TextCursorTest, NumbersAreWholeWords) {
  double value = 0;
  EXPECT_TRUE(ParseDouble("-1.5e-3", &value));
  EXPECT_EQ(value, -1.5e-3);
  EXPECT_TRUE(ParseDouble("+2", &value));
  EXPECT_EQ(value, 2);
  EXPECT_TRUE(ParseDouble("NaN", &value));
  EXPECT_TRUE(std::isnan(value));
  EXPECT_TRUE(ParseDouble("+inf", &value));
  EXPECT_TRUE(std::isinf(value));
  for (const char* bad : {"", "+", "+-1", "1x", "0x10", "one", "1,5"}) {
    EXPECT_FALSE(ParseDouble(bad, &value)) << bad;
  }
  int64_t integer = 0;
  EXPECT_TRUE(ParseInt("-7", &integer));
  EXPECT_EQ(integer, -7);
  EXPECT_FALSE(ParseInt("1.5", &integer));
  EXPECT_FALSE(ParseInt("99999999999999999999", &integer));
}

TEST(TextCursorTest, ABadLineIsQuotedWithoutControlCharacters) {
  const absl::Status status = BadLine(3, "\x1b[2Jx", "nothing");
  EXPECT_EQ(status.message(), "line 3 is \"\\033[2Jx\"; expected nothing");
}

}  // namespace
}  // namespace cagefit::client
