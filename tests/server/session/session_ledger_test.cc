#include "server/session/session_ledger.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/server/session/session_fixture.h"

namespace cagefit::server {
namespace {

using testing::CageConfig;
using ::testing::HasSubstr;
using testing::NewLedger;
using testing::ReasonOf;

VertexGrid Grid() { return {{1, 2, 3}, 0.25}; }

GridPoints State(int frame) {
  return GridPoints::NullaryExpr(3, 42, [frame](Eigen::Index r, Eigen::Index c) {
    return static_cast<int32_t>(frame * 1000 + 3 * c + r);
  });
}

// Frame `number` moves the grid points to State(number); a key frame at every third.
std::shared_ptr<StoredFrame> FittedFrame(int number, DeltaEncoding encoding) {
  auto frame = std::make_shared<StoredFrame>();
  frame->sequence_number = number;
  frame->outcome = Outcome::kFitted;
  frame->control_vertices = 42;
  frame->delta = *Encode(
      number % 3 == 0 ? EncodeKey(State(number)) : EncodeDelta(State(number - 1), State(number)),
      Grid(), encoding);
  return frame;
}

std::shared_ptr<StoredFrame> RejectedFrame(int number) {
  auto frame = std::make_shared<StoredFrame>();
  frame->sequence_number = number;
  frame->error = absl::InvalidArgumentError("bad");
  return frame;
}

ControlMesh SurfaceOf(const SessionLedger& ledger, int number) {
  return ledger.config().control_mesh->WithVertices(Dequantize(State(number), Grid()));
}

uint64_t Open(SessionLedger* ledger) {
  return ledger->OpenStream([](const absl::Status&) {}).value()->epoch;
}

TEST(SessionLedgerTest, BeginsWithTheFactsOfItsControlMesh) {
  const auto ledger = NewLedger(CageConfig());
  const SessionFacts facts = ledger->Facts();
  EXPECT_EQ(facts.epoch, 0u);
  EXPECT_EQ(facts.next_sequence_number, 0u);
  EXPECT_EQ(facts.control_vertices, 42);
  EXPECT_EQ(facts.triangles, 80);
  EXPECT_FALSE(facts.stream_attached);
}

TEST(SessionLedgerTest, OpeningRaisesTheEpochAndEndsTheOlderStream) {
  const auto ledger = NewLedger(CageConfig());
  absl::Status ended;
  int times = 0;
  // The ledger may be used from there: no lock is held.
  const auto first = ledger->OpenStream([&](const absl::Status& status) {
    ended = status;
    ++times;
    EXPECT_EQ(ledger->Facts().epoch, 2u);
  });
  ASSERT_TRUE(first.ok());
  EXPECT_EQ((*first)->epoch, 1u);
  EXPECT_EQ(Open(ledger.get()), 2u);
  EXPECT_TRUE(absl::IsAborted(ended)) << ended;
  EXPECT_EQ(ReasonOf(ended), "EPOCH_SUPERSEDED");
  EXPECT_EQ(Open(ledger.get()), 3u);
  EXPECT_EQ(times, 1);
}

TEST(SessionLedgerTest, OnlyTheLatestEpochMayWrite) {
  const auto ledger = NewLedger(CageConfig());
  const uint64_t older = Open(ledger.get()), newer = Open(ledger.get());
  EXPECT_TRUE(absl::IsAborted(ledger->CheckEpoch(older)));
  EXPECT_TRUE(absl::IsAborted(ledger->Append(older, RejectedFrame(0), {})));
  EXPECT_EQ(ledger->Facts().next_sequence_number, 0u);
  EXPECT_EQ(ledger->CheckEpoch(newer), absl::OkStatus());
  EXPECT_EQ(ledger->Append(newer, RejectedFrame(0), {}), absl::OkStatus());
  EXPECT_EQ(ledger->Facts().next_sequence_number, 1u);
}

TEST(SessionLedgerTest, ClosingDetachesOnlyTheStreamOfThatEpoch) {
  const auto ledger = NewLedger(CageConfig());
  const uint64_t older = Open(ledger.get()), newer = Open(ledger.get());
  ledger->CloseStream(older);
  EXPECT_TRUE(ledger->Facts().stream_attached);
  ledger->CloseStream(newer);
  EXPECT_FALSE(ledger->Facts().stream_attached);
}

TEST(SessionLedgerTest, AClosedStreamIsNotTold) {
  const auto ledger = NewLedger(CageConfig());
  int told = 0;
  const auto opening = ledger->OpenStream([&told](const absl::Status&) { ++told; });
  ledger->CloseStream((*opening)->epoch);
  Open(ledger.get());
  EXPECT_EQ(told, 0);
}

TEST(SessionLedgerTest, AJournalThatHasMovedOnHasToBeLoadedAnew) {
  MemoryJournal journal;
  SessionRecord record;
  record.id = "shared";
  record.config = CageConfig();
  ASSERT_TRUE(journal.Create(record).ok());
  SessionLedger here(record, std::nullopt, SessionLimits(), &journal);
  absl::Status ended;
  const auto opening =
      here.OpenStream([&ended](const absl::Status& status) { ended = status; }).value();
  ASSERT_TRUE(opening.has_value());
  // Another process takes over, and answers a frame.
  const SessionHead elsewhere = journal.RaiseEpoch("shared").value();
  ASSERT_TRUE(journal.Append("shared", elsewhere.epoch, RejectedFrame(0), nullptr).ok());

  EXPECT_EQ(ReasonOf(here.Append(opening->epoch, RejectedFrame(0), {})), "EPOCH_SUPERSEDED");
  EXPECT_FALSE(here.OpenStream([](const absl::Status&) {}).value().has_value());
  EXPECT_EQ(ReasonOf(ended), "EPOCH_SUPERSEDED");
  EXPECT_FALSE(here.Facts().stream_attached);
}

TEST(SessionLedgerTest, DeletingEndsTheStreamAndRefusesAllWrites) {
  const auto ledger = NewLedger(CageConfig());
  absl::Status ended;
  const auto opening = ledger->OpenStream([&ended](const absl::Status& status) { ended = status; });
  ledger->MarkDeleted();
  EXPECT_TRUE(absl::IsAborted(ended)) << ended;
  EXPECT_EQ(ReasonOf(ended), "SESSION_DELETED");
  EXPECT_EQ(ReasonOf(ledger->CheckEpoch((*opening)->epoch)), "SESSION_DELETED");
  EXPECT_FALSE(ledger->Append((*opening)->epoch, RejectedFrame(0), {}).ok());
  EXPECT_FALSE(ledger->OpenStream([](const absl::Status&) {}).value().has_value());
}

TEST(SessionLedgerTest, CountsAndFindsAnswers) {
  const auto ledger = NewLedger(CageConfig());
  const uint64_t epoch = Open(ledger.get());
  const auto fitted = FittedFrame(0, DeltaEncoding::kPacked);
  ASSERT_TRUE(ledger->Append(epoch, fitted, {}).ok());
  ASSERT_TRUE(ledger->Append(epoch, RejectedFrame(1), {}).ok());
  const SessionFacts facts = ledger->Facts();
  EXPECT_EQ(facts.next_sequence_number, 2u);
  EXPECT_EQ(facts.fitted_frames, 1u);
  EXPECT_EQ(facts.rejected_frames, 1u);
  EXPECT_EQ(ledger->Find(0).value(), fitted);
  EXPECT_EQ(ledger->Find(2).value(), nullptr);
  EXPECT_EQ(ledger->OpenStream([](const absl::Status&) {}).value()->next_sequence_number, 2u);
}

TEST(SessionLedgerTest, ReplaysEveryFittedFrameInBothEncodings) {
  for (const DeltaEncoding encoding : {DeltaEncoding::kPacked, DeltaEncoding::kDraco}) {
    const auto ledger = NewLedger(CageConfig());
    const uint64_t epoch = Open(ledger.get());
    for (int number = 0; number < 8; ++number) {
      ASSERT_TRUE(ledger->Append(epoch, FittedFrame(number, encoding), {}).ok());
    }
    for (int number = 0; number < 8; ++number) {
      EXPECT_EQ(ledger->StateOfFrame(number)->q, State(number));
      EXPECT_EQ(ledger->MeshOfFrame(number)->vertices(), Dequantize(State(number), Grid()));
    }
  }
}

TEST(SessionLedgerTest, ReplayPassesOverRejectedFrames) {
  const auto ledger = NewLedger(CageConfig());
  const uint64_t epoch = Open(ledger.get());
  ASSERT_TRUE(ledger->Append(epoch, FittedFrame(0, DeltaEncoding::kPacked), {}).ok());
  ASSERT_TRUE(ledger->Append(epoch, RejectedFrame(1), {}).ok());
  const auto third = FittedFrame(1, DeltaEncoding::kPacked);
  third->sequence_number = 2;
  ASSERT_TRUE(ledger->Append(epoch, third, {}).ok());
  EXPECT_EQ(ledger->StateOfFrame(2)->q, State(1));
}

TEST(SessionLedgerTest, AFrameThatWasNotFittedHasNoMesh) {
  const auto ledger = NewLedger(CageConfig());
  const uint64_t epoch = Open(ledger.get());
  ASSERT_TRUE(ledger->Append(epoch, RejectedFrame(0), {}).ok());
  for (const uint64_t number : {0u, 1u}) {
    const auto mesh = ledger->MeshOfFrame(number);
    EXPECT_TRUE(absl::IsNotFound(mesh.status())) << mesh.status();
    EXPECT_EQ(ReasonOf(mesh.status()), "FRAME_NOT_FITTED");
  }
}

TEST(SessionLedgerTest, TheLatestMeshIsTheTemplateUntilAFrameIsFitted) {
  const auto ledger = NewLedger(CageConfig());
  const uint64_t epoch = Open(ledger.get());
  EXPECT_EQ(ledger->LatestMesh()->vertices(), ledger->config().control_mesh->vertices());
  const ControlMesh surface = SurfaceOf(*ledger, 0);
  ASSERT_TRUE(ledger->Append(epoch, FittedFrame(0, DeltaEncoding::kPacked), {}).ok());
  EXPECT_EQ(ledger->LatestMesh()->vertices(), surface.vertices());
  EXPECT_EQ(ledger->TemplateMesh()->vertices(), ledger->config().control_mesh->vertices());
}

TEST(SessionLedgerTest, ATemplateThatIsStillToBeMadeIsAFailedPrecondition) {
  SessionConfig config;
  config.make_template.vertices = 42;
  const auto ledger = NewLedger(std::move(config));
  EXPECT_TRUE(absl::IsFailedPrecondition(ledger->TemplateMesh().status()));
  EXPECT_EQ(ReasonOf(ledger->LatestMesh().status()), "NO_TEMPLATE_YET");
  EXPECT_EQ(ledger->Facts().control_vertices, 0);

  const ControlMesh made = cagefit::testing::FrameCage();
  ASSERT_TRUE(
      ledger->Append(Open(ledger.get()), FittedFrame(0, DeltaEncoding::kPacked), made).ok());
  EXPECT_EQ(ledger->TemplateMesh()->vertices(), made.vertices());
  EXPECT_EQ(ledger->Facts().control_vertices, 42);
  EXPECT_EQ(ledger->Facts().triangles, 80);
}

TEST(SessionLedgerTest, KeepsPositionsWhereThereIsNoGrid) {
  SessionConfig config = CageConfig();
  config.quantum = 0;
  const auto ledger = NewLedger(std::move(config));
  const uint64_t epoch = Open(ledger.get());
  auto frame = std::make_shared<StoredFrame>();
  frame->outcome = Outcome::kFitted;
  frame->delta = EncodePositions(Points3f::Constant(3, 42, 0.1f));
  ASSERT_TRUE(ledger->Append(epoch, frame, {}).ok());
  EXPECT_EQ(ledger->MeshOfFrame(0)->vertices(), Points3d::Constant(3, 42, 0.1f));
}

TEST(SessionLedgerTest, HasNoRoomBeyondItsLimits) {
  SessionLimits limits;
  limits.max_frames = 1;
  const auto by_frames = NewLedger(CageConfig(), limits);
  EXPECT_EQ(by_frames->CheckRoom(), absl::OkStatus());
  ASSERT_TRUE(by_frames->Append(Open(by_frames.get()), RejectedFrame(0), {}).ok());
  EXPECT_TRUE(absl::IsResourceExhausted(by_frames->CheckRoom()));
  EXPECT_THAT(std::string(by_frames->CheckRoom().message()), HasSubstr("frames of a session"));

  limits = SessionLimits();
  limits.max_history_bytes = 1;
  const auto by_bytes = NewLedger(CageConfig(), limits);
  EXPECT_EQ(by_bytes->CheckRoom(), absl::OkStatus());
  ASSERT_TRUE(by_bytes->Append(Open(by_bytes.get()), RejectedFrame(0), {}).ok());
  EXPECT_TRUE(absl::IsResourceExhausted(by_bytes->CheckRoom()));
  EXPECT_EQ(DetailOf(by_bytes->CheckRoom())->limit, "1");
}

}  // namespace
}  // namespace cagefit::server
