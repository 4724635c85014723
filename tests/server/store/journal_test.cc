// What every journal promises.
#include "server/session/journal.h"

#include <gtest/gtest.h>

#include "server/store/memory_journal.h"
#include "tests/server/store/store_fixture.h"
#include "tests/support/postgres_server.h"

namespace cagefit::server {
namespace {

using testing::ReasonOf;
using testing::RecordOf;
using testing::RejectedAnswer;

class JournalTest : public ::testing::TestWithParam<const char*> {
 protected:
  JournalTest() {
    if (std::string(GetParam()) == "memory") {
      journal_ = std::make_unique<MemoryJournal>();
    } else if (std::string(GetParam()) == "postgres") {
      static cagefit::testing::PostgresServer server;
      journal_ = testing::OpenPostgres(server.NewDatabase(), &codec_);
    } else {
      journal_ = file_.Open();
    }
  }
  uint64_t Open(const std::string& id) { return journal_->RaiseEpoch(id)->epoch; }

  testing::StoreFile file_;
  ProtoRecordCodec codec_;
  std::unique_ptr<Journal> journal_;
};

TEST_P(JournalTest, LoadsWhatItCreated) {
  const SessionRecord record = RecordOf("one");
  ASSERT_TRUE(journal_->Create(record).ok());
  const auto loaded = journal_->Load("one");
  ASSERT_TRUE(loaded.ok()) << loaded.status();
  EXPECT_EQ(loaded->id, "one");
  EXPECT_EQ(loaded->owner, "somebody");
  EXPECT_EQ(loaded->created, record.created);
  EXPECT_EQ(loaded->config.name, record.config.name);
  EXPECT_FALSE(loaded->config.control_mesh.has_value());
  EXPECT_EQ(loaded->head.control_vertices, 42);
  EXPECT_EQ(loaded->head.triangles, 80);
  EXPECT_EQ(loaded->head.epoch, 0u);
  EXPECT_EQ(loaded->head.last_fitted, std::nullopt);
  const auto mesh = journal_->LoadTemplate("one");
  ASSERT_TRUE(mesh.ok()) << mesh.status();
  EXPECT_EQ((*mesh)->vertices(), record.config.control_mesh->vertices());
}

TEST_P(JournalTest, ASessionThatIsNotThereIsNotFound) {
  EXPECT_EQ(ReasonOf(journal_->Load("none").status()), "NO_SESSION");
  EXPECT_EQ(ReasonOf(journal_->LoadTemplate("none").status()), "NO_SESSION");
  EXPECT_EQ(ReasonOf(journal_->RaiseEpoch("none").status()), "NO_SESSION");
  EXPECT_EQ(ReasonOf(journal_->Delete("none")), "NO_SESSION");
  EXPECT_EQ(ReasonOf(journal_->Outlines("none").status()), "NO_SESSION");
  EXPECT_EQ(ReasonOf(journal_->Read("none", 0).status()), "NO_SESSION");
  EXPECT_EQ(ReasonOf(journal_->Begin("none", 1).status()), "SESSION_DELETED");
  EXPECT_EQ(ReasonOf(journal_->Append("none", 1, RejectedAnswer(0), nullptr)), "SESSION_DELETED");
}

TEST_P(JournalTest, ListsIdsInOrderAndCounts) {
  for (const char* id : {"b", "d", "a", "c"}) ASSERT_TRUE(journal_->Create(RecordOf(id)).ok());
  EXPECT_EQ(journal_->Count().value(), 4);
  const std::string owner = "somebody";
  EXPECT_EQ(journal_->Ids(owner, "", 2).value(), (std::vector<std::string>{"a", "b"}));
  EXPECT_EQ(journal_->Ids(owner, "b", 9).value(), (std::vector<std::string>{"c", "d"}));
  ASSERT_TRUE(journal_->Delete("c").ok());
  EXPECT_EQ(journal_->Ids(owner, "b", 9).value(), std::vector<std::string>{"d"});
  EXPECT_EQ(journal_->Count().value(), 3);
}

TEST_P(JournalTest, ListsAndCountsTheSessionsOfAnOwner) {
  for (const char* id : {"b", "d", "a", "c"}) {
    SessionRecord record = RecordOf(id);
    record.owner = id < std::string("c") ? "north" : "";
    ASSERT_TRUE(journal_->Create(record).ok());
  }
  EXPECT_EQ(journal_->Ids("north", "", 9).value(), (std::vector<std::string>{"a", "b"}));
  EXPECT_EQ(journal_->Ids("north", "a", 9).value(), std::vector<std::string>{"b"});
  EXPECT_EQ(journal_->Ids("", "", 1).value(), std::vector<std::string>{"c"});
  EXPECT_TRUE(journal_->Ids("south", "", 9)->empty());
  EXPECT_EQ(journal_->CountOf("north").value(), 2);
  EXPECT_EQ(journal_->CountOf("south").value(), 0);
  EXPECT_EQ(journal_->Load("a")->owner, "north");
}

TEST_P(JournalTest, OnlyTheLatestEpochWrites) {
  ASSERT_TRUE(journal_->Create(RecordOf("one")).ok());
  const uint64_t older = Open("one"), newer = Open("one");
  EXPECT_EQ(newer, older + 1);
  EXPECT_EQ(ReasonOf(journal_->Begin("one", older).status()), "EPOCH_SUPERSEDED");
  EXPECT_EQ(ReasonOf(journal_->Append("one", older, RejectedAnswer(0), nullptr)),
            "EPOCH_SUPERSEDED");
  EXPECT_EQ(journal_->Read("one", 0).value(), nullptr);
  EXPECT_TRUE(journal_->Append("one", newer, RejectedAnswer(0), nullptr).ok());
  EXPECT_NE(journal_->Read("one", 0).value(), nullptr);
  EXPECT_EQ(journal_->RaiseEpoch("one")->next_sequence_number, 1u);
}

TEST_P(JournalTest, CountsWhatWasBegunUntilItIsAnsweredOrAbandoned) {
  ASSERT_TRUE(journal_->Create(RecordOf("one")).ok());
  uint64_t epoch = Open("one");
  EXPECT_EQ(journal_->Begin("one", epoch).value(), 1);
  EXPECT_EQ(journal_->Begin("one", epoch).value(), 2);
  EXPECT_TRUE(journal_->Abandon("one", 0).ok());
  EXPECT_EQ(journal_->Begin("one", epoch).value(), 2);
  EXPECT_TRUE(journal_->Abandon("one", 1).ok());  // another frame
  EXPECT_EQ(journal_->Begin("one", epoch).value(), 3);
  epoch = Open("one");
  EXPECT_EQ(journal_->Begin("one", epoch).value(), 4);
  ASSERT_TRUE(journal_->Append("one", epoch, RejectedAnswer(0), nullptr).ok());
  EXPECT_EQ(journal_->Begin("one", epoch).value(), 1);
}

TEST_P(JournalTest, KeepsAnswersTheirOutlinesAndTheTemplateThatOneMade) {
  SessionConfig config;
  config.make_template.vertices = 42;
  ASSERT_TRUE(journal_->Create(RecordOf("one", config)).ok());
  EXPECT_FALSE(journal_->LoadTemplate("one")->has_value());
  const uint64_t epoch = Open("one");
  ASSERT_TRUE(journal_->Append("one", epoch, RejectedAnswer(0), nullptr).ok());
  auto fitted = std::make_shared<StoredFrame>();
  fitted->sequence_number = 1;
  fitted->outcome = Outcome::kFitted;
  fitted->verdict = Verdict::kSuspect;
  fitted->delta =
      *Encode(EncodeKey(GridPoints::Constant(3, 42, 9)), {{1, 2, 3}, 0.5}, DeltaEncoding::kPacked);
  fitted->distances.rms = 0.25;
  fitted->fit.samples = 4;
  fitted->fit.far_samples = 1;
  const ControlMesh made = cagefit::testing::FrameCage();
  ASSERT_TRUE(journal_->Append("one", epoch, fitted, &made).ok());

  const auto outlines = journal_->Outlines("one").value();
  ASSERT_EQ(outlines.size(), 2u);
  EXPECT_EQ(outlines[0].outcome, Outcome::kRejected);
  EXPECT_EQ(outlines[1].sequence_number, 1u);
  EXPECT_EQ(outlines[1].outcome, Outcome::kFitted);
  EXPECT_EQ(outlines[1].verdict, Verdict::kSuspect);
  EXPECT_TRUE(outlines[1].key);
  EXPECT_EQ(outlines[1].rms, 0.25);
  EXPECT_EQ(outlines[1].bare_share, 0.25);
  EXPECT_EQ(journal_->Read("one", 1).value()->delta.values, fitted->delta.values);
  EXPECT_EQ(ReasonOf(journal_->Read("one", 0).value()->error), "INVALID_FIELD");
  EXPECT_EQ(journal_->Read("one", 2).value(), nullptr);
  EXPECT_EQ((*journal_->LoadTemplate("one"))->vertices(), made.vertices());
  const SessionHead head = journal_->Load("one")->head;
  EXPECT_EQ(head.next_sequence_number, 2u);
  EXPECT_EQ(head.fitted_frames, 1u);
  EXPECT_EQ(head.rejected_frames, 1u);
  EXPECT_EQ(head.last_fitted, 1u);
  EXPECT_EQ(head.control_vertices, 42);
  EXPECT_EQ(head.triangles, 80);
  EXPECT_EQ(head.stored_bytes, fitted->StoredBytes() + RejectedAnswer(0)->StoredBytes());
}

TEST_P(JournalTest, CountsEveryKindOfAnswer) {
  ASSERT_TRUE(journal_->Create(RecordOf("one")).ok());
  const uint64_t epoch = Open("one");
  const std::vector<Outcome> outcomes = {Outcome::kSkipped, Outcome::kRejected, Outcome::kSkipped};
  for (size_t number = 0; number < outcomes.size(); ++number) {
    const auto answer = RejectedAnswer(number);
    answer->outcome = outcomes[number];
    ASSERT_TRUE(journal_->Append("one", epoch, answer, nullptr).ok());
  }
  const SessionHead head = journal_->Load("one")->head;
  EXPECT_EQ(head.skipped_frames, 2u);
  EXPECT_EQ(head.rejected_frames, 1u);
  EXPECT_EQ(head.fitted_frames, 0u);
  EXPECT_EQ(journal_->Read("one", 2).value()->outcome, Outcome::kSkipped);
}

TEST_P(JournalTest, ADeletedSessionTakesItsAnswersAlong) {
  ASSERT_TRUE(journal_->Create(RecordOf("one")).ok());
  const uint64_t epoch = Open("one");
  ASSERT_TRUE(journal_->Append("one", epoch, RejectedAnswer(0), nullptr).ok());
  ASSERT_TRUE(journal_->Delete("one").ok());
  EXPECT_EQ(ReasonOf(journal_->Append("one", epoch, RejectedAnswer(1), nullptr)),
            "SESSION_DELETED");
  ASSERT_TRUE(journal_->Create(RecordOf("one")).ok());
  EXPECT_TRUE(journal_->Outlines("one")->empty());
}

TEST_P(JournalTest, TellsWhatWasNotUsed) {
  const absl::Time then = absl::FromUnixSeconds(100);
  for (const char* id : {"a", "b", "c"}) ASSERT_TRUE(journal_->Create(RecordOf(id)).ok());
  ASSERT_TRUE(journal_->Touch({"b", "none"}, then).ok());
  EXPECT_EQ(journal_->UnusedSince(then, 9)->size(), 2u);
  EXPECT_EQ(journal_->UnusedSince(then, 1)->size(), 1u);
  Open("a");
  EXPECT_EQ(journal_->UnusedSince(then, 9).value(), std::vector<std::string>{"c"});
}

INSTANTIATE_TEST_SUITE_P(All, JournalTest, ::testing::Values("memory", "sqlite", "postgres"),
                         [](const auto& info) { return std::string(info.param); });

}  // namespace
}  // namespace cagefit::server
