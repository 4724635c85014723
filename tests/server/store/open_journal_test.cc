#include "server/store/open_journal.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/server/store/store_fixture.h"

namespace cagefit::server {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

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
  for (const char* name : {"", "sqlite:", "postgres:", "postgres:x", "Memory"}) {
    const auto journal = OpenJournal(name, &codec_);
    EXPECT_TRUE(absl::IsInvalidArgument(journal.status())) << name;
  }
}

TEST_F(OpenJournalTest, APasswordStaysOutOfTheName) {
  const auto journal = OpenJournal("postgres://somebody:secret@db/cagefit", &codec_);
  EXPECT_TRUE(absl::IsInvalidArgument(journal.status()));
  EXPECT_THAT(std::string(journal.status().message()),
              AllOf(HasSubstr("PGPASSWORD"), Not(HasSubstr("secret"))));
}

TEST_F(OpenJournalTest, ADatabaseThatIsAwayIsNoError) {
  const auto journal = OpenJournal("postgres://127.0.0.1:1/cagefit", &codec_);
  ASSERT_TRUE(journal.ok()) << journal.status();
  EXPECT_EQ(testing::ReasonOf((*journal)->Probe()), "STORE_UNAVAILABLE");
}

}  // namespace
}  // namespace cagefit::server
