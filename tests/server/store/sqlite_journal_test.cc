#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <linux/magic.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/vfs.h>

#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <random>

#include "absl/time/clock.h"
#include "server/store/sql_journal.h"
#include "server/store/sqlite.h"
#include "tests/server/store/store_fixture.h"

namespace cagefit::server {
namespace {

using ::testing::HasSubstr;
using testing::ReasonOf;
using testing::RecordOf;
using testing::RejectedAnswer;

class SqliteJournalTest : public ::testing::TestWithParam<SqliteJournalMode> {
 protected:
  // Waits as long as the journal does before it tries again.
  static absl::Status ProbeAgain(SqlJournal* journal) {
    absl::SleepFor(SqlJournal::kRetryInterval);
    return journal->Probe();
  }
  std::unique_ptr<SqlJournal> Open() const { return file_.Open(GetParam()); }
  testing::StoreFile file_;
};

INSTANTIATE_TEST_SUITE_P(Modes, SqliteJournalTest,
                         ::testing::Values(SqliteJournalMode::kWriteAheadLog,
                                           SqliteJournalMode::kRollback),
                         [](const auto& mode) {
                           return mode.param == SqliteJournalMode::kRollback ? "Rollback" : "Log";
                         });

// Files of this process cannot grow beyond what they have, as on a full disk.
class FullDisk {
 public:
  FullDisk() {
    signal(SIGXFSZ, SIG_IGN);
    getrlimit(RLIMIT_FSIZE, &old_);
    const rlimit full = {1, old_.rlim_max};
    setrlimit(RLIMIT_FSIZE, &full);
  }
  ~FullDisk() { setrlimit(RLIMIT_FSIZE, &old_); }

 private:
  rlimit old_ = {};
};

TEST_P(SqliteJournalTest, SessionsSurviveTheJournal) {
  uint64_t epoch = 0;
  {
    const auto journal = Open();
    ASSERT_TRUE(journal->Create(RecordOf("one")).ok());
    epoch = journal->RaiseEpoch("one")->epoch;
    ASSERT_TRUE(journal->Append("one", epoch, RejectedAnswer(0), nullptr).ok());
    EXPECT_EQ(journal->Begin("one", epoch).value(), 1);
  }
  const auto journal = Open();
  EXPECT_EQ(journal->Load("one")->head.next_sequence_number, 1u);
  EXPECT_EQ(journal->Begin("one", epoch).value(), 2);
  EXPECT_EQ(journal->Read("one", 0).value()->error, RejectedAnswer(0)->error);
  EXPECT_EQ(journal->RaiseEpoch("one")->epoch, epoch + 1);
}

TEST_P(SqliteJournalTest, TwoProcessesShareAFile) {
  const auto here = Open(), there = Open();
  ASSERT_TRUE(here->Create(RecordOf("one")).ok());
  const uint64_t older = here->RaiseEpoch("one")->epoch;
  const uint64_t newer = there->RaiseEpoch("one")->epoch;
  EXPECT_EQ(ReasonOf(here->Append("one", older, RejectedAnswer(0), nullptr)), "EPOCH_SUPERSEDED");
  EXPECT_TRUE(there->Append("one", newer, RejectedAnswer(0), nullptr).ok());
  EXPECT_EQ(here->Load("one")->head.next_sequence_number, 1u);
}

TEST_P(SqliteJournalTest, AnAnswerIsNeverStoredTwice) {
  const auto journal = Open();
  ASSERT_TRUE(journal->Create(RecordOf("one")).ok());
  const uint64_t epoch = journal->RaiseEpoch("one")->epoch;
  ASSERT_TRUE(journal->Append("one", epoch, RejectedAnswer(0), nullptr).ok());
  // As after a commit that seemed to fail: the stream's own epoch, but no longer the next frame.
  EXPECT_TRUE(absl::IsUnavailable(journal->Append("one", epoch, RejectedAnswer(0), nullptr)));
  absl::SleepFor(SqlJournal::kRetryInterval);
  EXPECT_EQ(journal->Outlines("one")->size(), 1u);
}

TEST_P(SqliteJournalTest, OnlyItsOwnerMayReadTheFile) {
  Open();
  for (const auto& entry : std::filesystem::directory_iterator(file_.folder())) {
    struct stat status = {};
    ASSERT_EQ(stat(entry.path().c_str(), &status), 0);
    EXPECT_EQ(status.st_mode & 0777, 0600u) << entry.path();
  }
}

TEST_P(SqliteJournalTest, AFullDiskIsUnavailableChangesNothingAndPasses) {
  const auto journal = Open();
  ASSERT_TRUE(journal->Create(RecordOf("one")).ok());
  const uint64_t epoch = journal->RaiseEpoch("one")->epoch;
  {
    const FullDisk full;
    const absl::Status refused = journal->Append("one", epoch, RejectedAnswer(0), nullptr);
    EXPECT_TRUE(absl::IsUnavailable(refused)) << refused;
    EXPECT_EQ(ReasonOf(refused), "STORE_UNAVAILABLE");
    EXPECT_FALSE(ProbeAgain(journal.get()).ok());
  }
  EXPECT_EQ(ProbeAgain(journal.get()), absl::OkStatus());
  EXPECT_EQ(journal->Load("one")->head.next_sequence_number, 0u);
  EXPECT_TRUE(journal->Append("one", epoch, RejectedAnswer(0), nullptr).ok());
}

TEST_P(SqliteJournalTest, AFileThatIsTakenAwayIsNotWrittenToUnseen) {
  const auto journal = Open();
  ASSERT_TRUE(journal->Create(RecordOf("one")).ok());
  const std::string hidden = file_.folder() + "/hidden";
  std::filesystem::create_directory(hidden);
  const auto move = [](const std::string& from, const std::string& to) {
    for (const char* suffix : {"", "-wal", "-shm", "-journal"}) {
      std::error_code missing;
      std::filesystem::rename(from + suffix, to + suffix, missing);
    }
  };
  move(file_.path(), hidden + "/store");
  std::filesystem::create_directory(file_.path());  // so that no new file can take its place
  EXPECT_TRUE(absl::IsUnavailable(journal->RaiseEpoch("one").status()));
  std::filesystem::remove(file_.path());
  move(hidden + "/store", file_.path());
  EXPECT_EQ(ProbeAgain(journal.get()), absl::OkStatus());
  EXPECT_EQ(journal->RaiseEpoch("one")->epoch, 1u);
}

TEST_P(SqliteJournalTest, AFileThatIsNoDatabaseIsUnavailableUntilItIsBack) {
  {
    const auto journal = Open();
    ASSERT_TRUE(journal->Create(RecordOf("one")).ok());
  }
  std::filesystem::rename(file_.path(), file_.path() + ".good");
  std::ofstream(file_.path()) << std::string(5000, 'x');
  const auto journal = Open();
  const absl::Status status = journal->Load("one").status();
  EXPECT_TRUE(absl::IsUnavailable(status)) << status;
  std::filesystem::rename(file_.path() + ".good", file_.path());
  EXPECT_EQ(ProbeAgain(journal.get()), absl::OkStatus());
  EXPECT_TRUE(journal->Load("one").ok());
}

TEST_P(SqliteJournalTest, ADamagedRecordIsDataLossOfItsSessionAlone) {
  {
    const auto journal = Open();
    for (const char* id : {"one", "two"}) {
      ASSERT_TRUE(journal->Create(RecordOf(id)).ok());
      ASSERT_TRUE(
          journal->Append(id, journal->RaiseEpoch(id)->epoch, RejectedAnswer(0), nullptr).ok());
    }
  }
  {
    const auto database = SqliteDatabase::Open(file_.path(), GetParam()).value();
    ASSERT_TRUE(database
                    ->Execute("UPDATE frame SET record = x'0a0b' WHERE session = 1;"
                              "UPDATE session SET template = x'0a0b' WHERE id = 'one'")
                    .ok());
  }
  const auto journal = Open();
  EXPECT_TRUE(absl::IsDataLoss(journal->Read("one", 0).status()));
  EXPECT_TRUE(absl::IsDataLoss(journal->LoadTemplate("one").status()));
  EXPECT_TRUE(journal->Read("two", 0).ok());
  EXPECT_EQ(journal->Probe(), absl::OkStatus());
}

TEST_P(SqliteJournalTest, AFileCutAnywhereNeverGivesOtherAnswers) {
  constexpr int kSessions = 3, kAnswers = 20;
  {
    const auto journal = Open();
    for (int s = 0; s < kSessions; ++s) {
      const std::string id = std::to_string(s);
      ASSERT_TRUE(journal->Create(RecordOf(id)).ok());
      const uint64_t epoch = journal->RaiseEpoch(id)->epoch;
      for (int k = 0; k < kAnswers; ++k) {
        ASSERT_TRUE(journal->Append(id, epoch, RejectedAnswer(k), nullptr).ok());
      }
    }
  }  // the log is in the file now
  const auto size = static_cast<int64_t>(std::filesystem::file_size(file_.path()));
  const std::string whole = file_.path() + ".whole";
  std::filesystem::copy_file(file_.path(), whole);
  // CAGEFIT_CUTS=1000 takes some minutes.
  const char* wanted = std::getenv("CAGEFIT_CUTS");
  const int cuts = wanted == nullptr ? 20 : std::atoi(wanted);
  std::mt19937 random(7);
  for (int cut = 0; cut < cuts; ++cut) {
    const int64_t bytes = std::uniform_int_distribution<int64_t>(1, size - 1)(random);
    std::filesystem::copy_file(whole, file_.path(),
                               std::filesystem::copy_options::overwrite_existing);
    std::filesystem::resize_file(file_.path(), bytes);
    for (const char* suffix : {"-wal", "-shm", "-journal"})
      std::filesystem::remove(file_.path() + suffix);
    const auto journal = Open();
    EXPECT_TRUE(absl::IsUnavailable(journal->Probe())) << bytes << " of " << size;
    std::filesystem::rename(file_.path(), file_.path() + ".cut");
    std::filesystem::copy_file(whole, file_.path());
    for (const char* suffix : {"-wal", "-shm", "-journal"})
      std::filesystem::remove(file_.path() + suffix);
    EXPECT_EQ(ProbeAgain(journal.get()), absl::OkStatus());
    EXPECT_EQ(journal->Load("1")->head.next_sequence_number, uint64_t{kAnswers});
    EXPECT_NE(journal->Read("1", kAnswers - 1).value(), nullptr);
  }
}

TEST(SqliteJournalModeTest, ALogIsKeptOnlyWhereMachinesDoNotShareFiles) {
  for (const int64_t local : {EXT4_SUPER_MAGIC, XFS_SUPER_MAGIC, TMPFS_MAGIC}) {
    EXPECT_EQ(JournalModeOn(local), SqliteJournalMode::kWriteAheadLog) << local;
  }
  for (const int64_t shared : std::vector<int64_t>{NFS_SUPER_MAGIC, SMB2_SUPER_MAGIC,
                                                   FUSE_SUPER_MAGIC, CEPH_SUPER_MAGIC}) {
    EXPECT_EQ(JournalModeOn(shared), SqliteJournalMode::kRollback) << shared;
  }
}

// The log lies beside the file while it is open, as the sign of its mode.
TEST(SqliteJournalModeTest, FollowsTheFileSystem) {
  const testing::StoreFile file;
  struct statfs status = {};
  ASSERT_EQ(statfs(file.folder().c_str(), &status), 0);
  const auto database = SqliteDatabase::Open(file.path());
  ASSERT_TRUE(database.ok()) << database.status();
  EXPECT_EQ(std::filesystem::exists(file.path() + "-wal"),
            JournalModeOn(status.f_type) == SqliteJournalMode::kWriteAheadLog);
}

TEST(SqliteJournalModeTest, AFileChangesItsModeUnlessItIsOpenElsewhere) {
  const testing::StoreFile file;
  ASSERT_TRUE(file.Open()->Create(RecordOf("one")).ok());
  {
    const auto log = SqliteDatabase::Open(file.path(), SqliteJournalMode::kWriteAheadLog);
    ASSERT_TRUE(log.ok()) << log.status();
    const absl::Status refused =
        SqliteDatabase::Open(file.path(), SqliteJournalMode::kRollback).status();
    EXPECT_TRUE(absl::IsUnavailable(refused)) << refused;
  }
  EXPECT_TRUE(file.Open(SqliteJournalMode::kRollback)->Load("one").ok());
  EXPECT_FALSE(std::filesystem::exists(file.path() + "-wal"));
  EXPECT_TRUE(file.Open()->Load("one").ok());
}

}  // namespace
}  // namespace cagefit::server
