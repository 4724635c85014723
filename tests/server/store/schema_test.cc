#include "server/store/schema.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/server/store/store_fixture.h"

namespace cagefit::server {
namespace {

using ::testing::HasSubstr;

class SchemaTest : public ::testing::Test {
 protected:
  testing::StoreFile file_;
  std::unique_ptr<SqliteDatabase> database_ = SqliteDatabase::Open(file_.path()).value();
  const std::vector<std::string> first_ = {"CREATE TABLE a (x INTEGER)"};
  const std::vector<std::string> second_ = {first_[0], "ALTER TABLE a ADD COLUMN y DEFAULT 7"};
};

TEST_F(SchemaTest, TakesTheStepsThatAnOlderStoreLacksAndKeepsItsRows) {
  ASSERT_EQ(Migrate(database_.get(), first_), absl::OkStatus());
  ASSERT_TRUE(database_->Execute("INSERT INTO a VALUES (5)").ok());
  ASSERT_EQ(Migrate(database_.get(), second_), absl::OkStatus());
  ASSERT_EQ(Migrate(database_.get(), second_), absl::OkStatus());
  EXPECT_EQ(database_->Number("SELECT x + y FROM a").value(), 12);
  EXPECT_EQ(database_->Number("PRAGMA user_version").value(), 2);
}

TEST_F(SchemaTest, LeavesALaterStoreAsItIs) {
  ASSERT_EQ(Migrate(database_.get(), second_), absl::OkStatus());
  const absl::Status refused = Migrate(database_.get(), first_);
  EXPECT_TRUE(absl::IsFailedPrecondition(refused)) << refused;
  EXPECT_THAT(std::string(refused.message()), HasSubstr("version 2"));
  EXPECT_EQ(database_->Number("PRAGMA user_version").value(), 2);
}

TEST_F(SchemaTest, AStepThatFailsLeavesNothingBehind) {
  const std::vector<std::string> broken = {first_[0], "CREATE TABLE b (x); CREATE TABLE a (x)"};
  EXPECT_FALSE(Migrate(database_.get(), broken).ok());
  EXPECT_EQ(database_->Number("PRAGMA user_version").value(), 1);
  EXPECT_EQ(database_->Number("SELECT count(*) FROM sqlite_schema WHERE name = 'b'").value(), 0);
}

TEST_F(SchemaTest, RefusesTheDatabaseOfAnotherProgram) {
  ASSERT_TRUE(database_->Execute("CREATE TABLE theirs (x)").ok());
  const absl::Status refused = Migrate(database_.get(), first_);
  EXPECT_TRUE(absl::IsFailedPrecondition(refused)) << refused;
  EXPECT_THAT(std::string(refused.message()), HasSubstr("another program"));
}

}  // namespace
}  // namespace cagefit::server
