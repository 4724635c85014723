#include "server/store/open_journal.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/server/store/store_fixture.h"

namespace cagefit::server {
namespace {

using ::testing::HasSubstr;

class OpenJournalTest : public ::testing::Test {
 protected:
  ProtoRecordCodec codec_;
  testing::StoreFile file_;
};

TEST_F(OpenJournalTest, MakesBothKinds) {
  EXPECT_FALSE(OpenJournal("memory", &codec_).value()->is_durable());
  EXPECT_TRUE(OpenJournal("sqlite:" + file_.path(), &codec_).value()->is_durable());
}

TEST_F(OpenJournalTest, MakesTheFoldersOfTheFile) {
  const auto journal = OpenJournal("sqlite:" + file_.folder() + "/new/folders/store.db", &codec_);
  ASSERT_TRUE(journal.ok()) << journal.status();
  EXPECT_EQ((*journal)->Probe(), absl::OkStatus());
}

TEST_F(OpenJournalTest, NamesTheFolderThatCannotBeMade) {
  const auto journal = OpenJournal("sqlite:/proc/none/store.db", &codec_);
  EXPECT_TRUE(absl::IsFailedPrecondition(journal.status())) << journal.status();
  EXPECT_THAT(std::string(journal.status().message()), HasSubstr("/proc/none"));
}

TEST_F(OpenJournalTest, RefusesOtherNames) {
  for (const char* name : {"", "sqlite:", "postgres:x", "Memory"}) {
    const auto journal = OpenJournal(name, &codec_);
    EXPECT_TRUE(absl::IsInvalidArgument(journal.status())) << name;
  }
}

}  // namespace
}  // namespace cagefit::server
