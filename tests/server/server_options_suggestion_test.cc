#include "server/server_options_suggestion.h"

#include <gtest/gtest.h>

namespace cagefit::server {
namespace {

TEST(SuggestionTest, IsTheNearestName) {
  const std::vector<std::string> names = {"max-points", "max-frames", "max-frame-mib", "listen"};
  EXPECT_EQ(Suggestion("max-point", names), "; did you mean max-points?");
  EXPECT_EQ(Suggestion("max-fraems", names), "; did you mean max-frames?");
  EXPECT_EQ(Suggestion("lisen", names), "; did you mean listen?");
  EXPECT_EQ(Suggestion("isten", names), "; did you mean listen?");
}

TEST(SuggestionTest, IsNoneWhereNothingIsNear) {
  EXPECT_EQ(Suggestion("verbosity", {"listen", "max-points"}), "");
  EXPECT_EQ(Suggestion("", {"listen"}), "");
  EXPECT_EQ(Suggestion("listen", {}), "");
}

}  // namespace
}  // namespace cagefit::server
