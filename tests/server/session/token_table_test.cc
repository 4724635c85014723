#include "server/session/token_table.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "absl/strings/escaping.h"
#include "absl/strings/str_cat.h"

namespace cagefit::server {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

const absl::Time kNow = absl::FromUnixSeconds(1'800'000'000);

std::string HexOf(const std::string& token) {
  const Digest digest = Sha256(token);
  return absl::BytesToHexString(
      absl::string_view(reinterpret_cast<const char*>(digest.data()), digest.size()));
}

absl::StatusOr<TokenTable> Parse(const std::string& text, const TokenTable* before = nullptr) {
  return TokenTable::Parse("f", text, before);
}

TEST(TokenTableTest, FindsWhoseATokenIs) {
  const auto table = Parse(absl::StrCat("# rigs\n\nnorth ", HexOf("secret"), "\nsouth\t ",
                                        HexOf("other"), "  # the new one\r\n"));
  ASSERT_TRUE(table.ok()) << table.status();
  EXPECT_EQ(table->Find("secret", kNow)->name, "north");
  EXPECT_EQ(table->Find("other", kNow)->name, "south");
  EXPECT_EQ(table->token_count(), 2u);
}

TEST(TokenTableTest, NobodyHasAnotherToken) {
  const auto table = Parse("north " + HexOf("secret"));
  ASSERT_TRUE(table.ok()) << table.status();
  for (const std::string& token :
       {std::string(), std::string("secre"), std::string("secret "), HexOf("secret"),
        std::string("north"), std::string(TokenTable::kMaxTokenBytes + 1, 'x')}) {
    EXPECT_EQ(table->Find(token, kNow), nullptr) << token;
  }
}

TEST(TokenTableTest, ATokenIsGoodUntilItExpires) {
  const auto table = Parse("north " + HexOf("secret") + " expires=" +
                           absl::FormatTime(absl::RFC3339_full, kNow, absl::UTCTimeZone()));
  ASSERT_TRUE(table.ok()) << table.status();
  EXPECT_NE(table->Find("secret", kNow - absl::Nanoseconds(1)), nullptr);
  EXPECT_EQ(table->Find("secret", kNow), nullptr);
}

TEST(TokenTableTest, TwoTokensOfANameAreOnePrincipal) {
  const auto table = Parse(absl::StrCat("north ", HexOf("old"), " fits=2\nnorth ", HexOf("new"),
                                        " fits=2 expires=2030-01-01T00:00:00Z\n"));
  ASSERT_TRUE(table.ok()) << table.status();
  EXPECT_EQ(table->Find("old", kNow), table->Find("new", kNow));
}

TEST(TokenTableTest, QuotasArrive) {
  const auto table =
      Parse("north " + HexOf("secret") + " sessions=3 bytes-per-second=4000000000 fits=5");
  ASSERT_TRUE(table.ok()) << table.status();
  const auto principal = table->Find("secret", kNow);
  EXPECT_EQ(principal->quotas.sessions, 3);
  EXPECT_EQ(principal->quotas.bytes_per_second, 4'000'000'000);
  EXPECT_EQ(principal->quotas.fits, 5);
}

TEST(TokenTableTest, WhatIsUsedGoesOnCountingInTheNextTable) {
  const auto before = Parse("north " + HexOf("a") + " fits=1");
  ASSERT_TRUE(before.ok());
  const auto after =
      Parse(absl::StrCat("north ", HexOf("b"), " fits=2\nsouth ", HexOf("c")), &*before);
  ASSERT_TRUE(after.ok());
  EXPECT_EQ(after->Find("b", kNow)->rate, before->Find("a", kNow)->rate);
  EXPECT_EQ(after->Find("b", kNow)->fits, before->Find("a", kNow)->fits);
  EXPECT_EQ(after->Find("b", kNow)->quotas.fits, 2);
  EXPECT_NE(after->Find("c", kNow)->rate, before->Find("a", kNow)->rate);
}

TEST(TokenTableTest, ABadLineIsNamedAndNotQuoted) {
  const std::string good = "north " + HexOf("secret");
  const std::vector<std::pair<std::string, std::string>> bad = {
      {"north", "SHA-256"},
      {"north secret", "SHA-256"},
      {"north " + HexOf("secret").substr(1), "SHA-256"},
      {"north g" + HexOf("secret").substr(1), "SHA-256"},
      {"no/rth " + HexOf("x"), "name"},
      {std::string(65, 'n') + " " + HexOf("x"), "name"},
      {"south " + HexOf("secret"), "earlier line"},
      {"north " + HexOf("x") + " fits=1", "other quotas"},
      {"south " + HexOf("x") + " fits=0", "fits is \"0\""},
      {"south " + HexOf("x") + " sessions=many", "sessions is \"many\""},
      {"south " + HexOf("x") + " bytes-per-second=", "bytes-per-second is \"\""},
      {"south " + HexOf("x") + " fits=1 fits=1", "twice"},
      {"south " + HexOf("x") + " frames=1", "unknown setting"},
      {"south " + HexOf("x") + " expires=tomorrow", "expires is \"tomorrow\""}};
  for (const auto& [line, what] : bad) {
    const absl::Status status = Parse("# first\n" + good + "\n" + line + "\n").status();
    EXPECT_TRUE(absl::IsInvalidArgument(status)) << line;
    EXPECT_THAT(std::string(status.message()),
                AllOf(::testing::StartsWith("f:3: "), HasSubstr(what), Not(HasSubstr("secret")),
                      Not(HasSubstr(HexOf("x")))));
  }
}

TEST(TokenTableTest, TooManyTokensAreAnError) {
  std::string text;
  for (size_t k = 0; k <= TokenTable::kMaxTokens; ++k) {
    absl::StrAppend(&text, "north ", HexOf(absl::StrCat(k)), "\n");
  }
  EXPECT_THAT(std::string(Parse(text).status().message()), HasSubstr("more than 4096 tokens"));
}

}  // namespace
}  // namespace cagefit::server
