#include "client/io/text_line.h"

#include "absl/status/statusor.h"
#include "tests/client/io/expect_error.h"

namespace cagefit::client {
namespace {

using ::testing::ElementsAre;

// EXPECT_INVALID wants what has a status().
absl::StatusOr<int> Failed(const absl::Status& status) { return status; }

TEST(TextLineTest, SkipsBlankLinesAndComments) {
  TextCursor cursor("# a\n\n  # b\r\n1 x#2\n\n3");
  TextLine line;
  ASSERT_TRUE(line.Next(&cursor));
  EXPECT_EQ(line.number, 4);
  EXPECT_THAT(line.words, ElementsAre("1", "x#2"));
  ASSERT_TRUE(line.Next(&cursor));
  EXPECT_EQ(line.number, 6);
  EXPECT_FALSE(line.Next(&cursor));
}

TEST(TextLineTest, ErrorsNameLineFieldAndValue) {
  TextCursor cursor("\nnan 1e3 12 x");
  TextLine line;
  ASSERT_TRUE(line.Next(&cursor));
  double number = 0;
  int64_t whole = 0;
  EXPECT_INVALID(Failed(line.ReadDouble(0, "TX", &number)),
                 "line 2: TX is \"nan\"; expected a finite number");
  EXPECT_INVALID(Failed(line.ReadDouble(3, "TX", &number)), "line 2: TX is \"x\"");
  EXPECT_INVALID(Failed(line.ReadInt(1, "WIDTH", &whole)),
                 "line 2: WIDTH is \"1e3\"; expected a whole number");
  EXPECT_TRUE(line.ReadDouble(1, "TX", &number).ok());
  EXPECT_EQ(number, 1000);
  EXPECT_TRUE(line.ReadInt(2, "WIDTH", &whole).ok());
  EXPECT_EQ(whole, 12);
  EXPECT_INVALID(Failed(line.Wrong("NAME", std::string(80, 'n') + "\n", "less")),
                 std::string(60, 'n') + "...\"");
  EXPECT_INVALID(Failed(line.Located(absl::InvalidArgumentError("so"))), "line 2: so");
}

}  // namespace
}  // namespace cagefit::client
