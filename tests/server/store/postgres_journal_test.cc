// Servers that share a database of PostgreSQL, and what becomes of it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <thread>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "server/store/schema.h"
#include "tests/server/store/store_fixture.h"
#include "tests/support/postgres_server.h"

namespace cagefit::server {
namespace {

using cagefit::testing::PostgresServer;
using ::testing::HasSubstr;
using testing::ReasonOf;
using testing::RecordOf;
using testing::RejectedAnswer;

class PostgresJournalTest : public ::testing::Test {
 protected:
  std::unique_ptr<SqlJournal> Open() { return testing::OpenPostgres(url_, &codec_); }
  std::unique_ptr<PostgresDatabase> Database() { return PostgresDatabase::Open(url_).value(); }
  // Waits as long as the journal does before it tries again.
  static absl::Status ProbeAgain(SqlJournal* journal) {
    absl::SleepFor(SqlJournal::kRetryInterval);
    return journal->Probe();
  }

  PostgresServer server_;
  const std::string url_ = server_.NewDatabase();
  ProtoRecordCodec codec_;
};

TEST_F(PostgresJournalTest, ManyServersMakeTheTablesOfANewDatabase) {
  std::vector<std::thread> servers;
  std::atomic<int> ready{0};
  for (int k = 0; k < 8; ++k) {
    servers.emplace_back([&] { ready += Open()->Probe().ok(); });
  }
  for (std::thread& server : servers) server.join();
  EXPECT_EQ(ready, 8);
  EXPECT_EQ(Database()->Number("SELECT count(*) FROM cagefit_version").value(), 1);
}

// Two servers have opened the session, one after the other, and both write.
TEST_F(PostgresJournalTest, OfTwoServersOnlyTheLatestEpochWrites) {
  const auto here = Open(), there = Open();
  ASSERT_TRUE(here->Create(RecordOf("one")).ok());
  uint64_t number = 0;
  for (int round = 0; round < 20; ++round) {
    SqlJournal* const older = (round % 2 == 0 ? here : there).get();
    SqlJournal* const newer = (round % 2 == 0 ? there : here).get();
    const uint64_t epoch = older->RaiseEpoch("one")->epoch;
    std::atomic<uint64_t> stored{0};
    std::thread writer([&] {
      for (uint64_t k = number; k < number + 10'000; ++k) {
        const absl::Status status = older->Append("one", epoch, RejectedAnswer(k), nullptr);
        if (!status.ok()) {
          EXPECT_EQ(ReasonOf(status), "EPOCH_SUPERSEDED") << status;
          return;
        }
        ++stored;
      }
      ADD_FAILURE() << "the older epoch writes on";
    });
    while (stored < 3) std::this_thread::yield();
    const auto head = newer->RaiseEpoch("one");
    ASSERT_TRUE(head.ok()) << head.status();
    writer.join();
    // Nothing came after the newer one looked.
    EXPECT_EQ(head->next_sequence_number, number + stored);
    number = head->next_sequence_number;
    EXPECT_EQ(newer->Load("one")->head.next_sequence_number, number);
  }
  const auto outlines = here->Outlines("one");
  ASSERT_TRUE(outlines.ok());
  ASSERT_EQ(outlines->size(), number);
  for (uint64_t k = 0; k < number; ++k) EXPECT_EQ((*outlines)[k].sequence_number, k);
}

TEST_F(PostgresJournalTest, ASessionDeletedUnderItsStreamLeavesNothing) {
  const auto here = Open(), there = Open();
  for (int round = 0; round < 20; ++round) {
    const std::string id = absl::StrCat("session", round);
    ASSERT_TRUE(here->Create(RecordOf(id)).ok());
    const uint64_t epoch = here->RaiseEpoch(id)->epoch;
    std::atomic<int> stored{0};
    std::thread writer([&] {
      absl::Status status;
      for (uint64_t k = 0; status.ok(); ++k) {
        status = here->Append(id, epoch, RejectedAnswer(k), nullptr);
        ++stored;
      }
      EXPECT_EQ(ReasonOf(status), "SESSION_DELETED") << status;
    });
    while (stored < 2) std::this_thread::yield();
    EXPECT_EQ(there->Delete(id), absl::OkStatus());
    writer.join();
  }
  EXPECT_EQ(Database()->Number("SELECT count(*) FROM frame").value(), 0);
  EXPECT_EQ(here->Count().value(), 0);
}

TEST_F(PostgresJournalTest, ADatabaseThatCrashesIsUnavailableUntilItIsBack) {
  const auto journal = Open();
  ASSERT_TRUE(journal->Create(RecordOf("one")).ok());
  const uint64_t epoch = journal->RaiseEpoch("one")->epoch;
  ASSERT_TRUE(journal->Append("one", epoch, RejectedAnswer(0), nullptr).ok());
  server_.Stop();
  EXPECT_EQ(ReasonOf(journal->Append("one", epoch, RejectedAnswer(1), nullptr)),
            "STORE_UNAVAILABLE");
  EXPECT_EQ(ReasonOf(ProbeAgain(journal.get())), "STORE_UNAVAILABLE");
  server_.Start();
  EXPECT_EQ(ProbeAgain(journal.get()), absl::OkStatus());
  EXPECT_EQ(journal->Load("one")->head.next_sequence_number, 1u);
  EXPECT_EQ(journal->Append("one", epoch, RejectedAnswer(1), nullptr), absl::OkStatus());
}

TEST_F(PostgresJournalTest, ADatabaseThatStandsStillIsNotWaitedForForEver) {
  const auto journal = Open();
  server_.Freeze();
  const absl::Time start = absl::Now();
  const absl::Status status = journal->Probe();
  EXPECT_EQ(ReasonOf(status), "STORE_UNAVAILABLE");
  EXPECT_THAT(std::string(status.message()), HasSubstr("has not answered for 10s"));
  EXPECT_LT(absl::Now() - start, absl::Seconds(15));
  server_.Thaw();
  EXPECT_EQ(ProbeAgain(journal.get()), absl::OkStatus());
}

TEST_F(PostgresJournalTest, CommitsAreDurableWhateverTheDefault) {
  ASSERT_TRUE(Database()->Execute("ALTER ROLE cagefit SET synchronous_commit = off").ok());
  EXPECT_EQ(Database()
                ->Number("SELECT count(*) FROM pg_settings WHERE name = 'synchronous_commit' "
                         "AND setting = 'on'")
                .value(),
            1);
}

TEST_F(PostgresJournalTest, RefusesTheTablesOfAnotherProgram) {
  ASSERT_TRUE(Database()->Execute("CREATE TABLE session (theirs integer)").ok());
  const auto journal =
      SqlJournal::Open([this] { return PostgresDatabase::Open(url_); }, 1, &codec_);
  EXPECT_TRUE(absl::IsFailedPrecondition(journal.status())) << journal.status();
  EXPECT_THAT(std::string(journal.status().message()), HasSubstr("another program"));
}

TEST_F(PostgresJournalTest, TakesTheStepsThatAnOlderStoreLacksAndLeavesALaterOne) {
  const auto database = Database();
  const std::vector<std::string> first = {"CREATE TABLE a (x {integer})"};
  const std::vector<std::string> second = {first[0],
                                           "ALTER TABLE a ADD COLUMN y {integer} DEFAULT 7"};
  ASSERT_EQ(Migrate(database.get(), first), absl::OkStatus());
  ASSERT_TRUE(database->Execute("INSERT INTO a VALUES (5)").ok());
  ASSERT_EQ(Migrate(database.get(), second), absl::OkStatus());
  EXPECT_EQ(database->Number("SELECT x + y FROM a").value(), 12);
  EXPECT_TRUE(absl::IsFailedPrecondition(Migrate(database.get(), first)));
}

TEST_F(PostgresJournalTest, AnIdWithAZeroByteIsNobodysAndBreaksNothing) {
  const auto journal = Open();
  const std::string id("a\0b", 3);
  EXPECT_TRUE(absl::IsInvalidArgument(journal->Load(id).status()));
  EXPECT_EQ(journal->Probe(), absl::OkStatus());
}

}  // namespace
}  // namespace cagefit::server
