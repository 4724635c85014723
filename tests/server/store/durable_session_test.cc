// Sessions whose process ends between frames, behind a store in a file.
#include <gtest/gtest.h>

#include <optional>

#include "server/session/session_store.h"
#include "tests/server/store/store_fixture.h"

namespace cagefit::server {
namespace {

using cagefit::testing::FrameCage;
using testing::CageConfig;
using testing::DecodedFrame;
using testing::MovingFrame;

// A server without a network.
class Process {
 public:
  explicit Process(const testing::StoreFile& file)
      : journal_(file.Open()), store_(SessionStore::Limits(), journal_.get(), &templates_, NoTime) {
    templates_.result = FrameCage();
  }

  SessionStore& store() { return store_; }
  void Open(const std::string& id) {
    const auto opened = store_.OpenStream(id, [](const absl::Status&) {});
    ASSERT_TRUE(opened.ok()) << opened.status();
    opened_ = *opened;
  }
  StoredFrame Answer(Frame frame) {
    const SessionLease session = store_.Lease(opened_->ledger->id()).value();
    const auto answer = session->Answer(std::move(frame), opened_->opening.epoch, nullptr);
    EXPECT_TRUE(answer.ok()) << answer.status();
    return *answer->frame;
  }
  uint64_t next_sequence_number() const { return opened_->opening.next_sequence_number; }

 private:
  static double NoTime() { return 0; }
  testing::FakeTemplates templates_;
  std::unique_ptr<SqlJournal> journal_;
  SessionStore store_;
  std::optional<SessionStore::OpenedStream> opened_;
};

Frame FrameOf(uint64_t number) {
  return number == 2 ? DecodedFrame(number, "no Draco") : MovingFrame(number);
}

SessionConfig MadeTemplate() {
  SessionConfig config;
  config.make_template.vertices = 42;
  config.key_interval = 3;
  config.delta_encoding = DeltaEncoding::kDraco;
  return config;
}

SessionConfig Positions() {
  SessionConfig config = CageConfig();
  config.quantum = 0;
  return config;
}

SessionConfig Tolerance() {
  SessionConfig config = CageConfig();
  config.tolerance = ToleranceOptions{0.01, 0};
  config.make_template.vertices = SessionConfig::kToleranceStartVertices;
  return config;
}

SessionConfig ConfigOf(const std::string& kind) {
  if (kind == "made") return MadeTemplate();
  if (kind == "positions") return Positions();
  if (kind == "tolerance") return Tolerance();
  return CageConfig();
}

class DurableSessionTest : public ::testing::TestWithParam<const char*> {
 protected:
  static constexpr uint64_t kFrames = 7;

  static std::string Create(const testing::StoreFile& file) {
    Process process(file);
    return (*process.store().Create(Principal(), ConfigOf(GetParam()), absl::Now()))->id();
  }
  static Points3d Vertices(const testing::StoreFile& file, const std::string& id, uint64_t number) {
    Process process(file);
    return process.store().Find(id).value()->MeshOfFrame(number)->vertices();
  }
};

TEST_P(DurableSessionTest, AProcessPerFrameFitsTheSameBitsAsOneForAll) {
  const testing::StoreFile one_file, many_file;
  const std::string one = Create(one_file), many = Create(many_file);
  {
    Process process(one_file);
    process.Open(one);
    for (uint64_t number = 0; number < kFrames; ++number) process.Answer(FrameOf(number));
  }
  for (uint64_t number = 0; number < kFrames; ++number) {
    Process process(many_file);
    process.Open(many);
    EXPECT_EQ(process.next_sequence_number(), number);
    const StoredFrame answer = process.Answer(FrameOf(number));
    EXPECT_EQ(answer.outcome, number == 2 ? Outcome::kRejected : Outcome::kFitted);
  }
  for (uint64_t number = 0; number < kFrames; ++number) {
    if (number == 2) continue;
    EXPECT_EQ(Vertices(many_file, many, number), Vertices(one_file, one, number)) << number;
  }
}

TEST_P(DurableSessionTest, ARepeatedFrameGetsItsAnswerFromTheFile) {
  const testing::StoreFile file;
  const std::string id = Create(file);
  StoredFrame first;
  {
    Process process(file);
    process.Open(id);
    for (uint64_t number = 0; number < 4; ++number) first = process.Answer(FrameOf(number));
  }
  Process process(file);
  process.Open(id);
  const StoredFrame again = process.Answer(FrameOf(3));
  EXPECT_EQ(again.digest, first.digest);
  EXPECT_EQ(again.delta.checksum, first.delta.checksum);
  EXPECT_EQ(again.distances.rms, first.distances.rms);
  EXPECT_EQ(again.fit.iterations, first.fit.iterations);
}

INSTANTIATE_TEST_SUITE_P(All, DurableSessionTest,
                         ::testing::Values("cage", "made", "positions", "tolerance"),
                         [](const auto& info) { return std::string(info.param); });

TEST(SharedStoreTest, WhatAnotherServerDidIsSeen) {
  const testing::StoreFile file;
  Process here(file), there(file);
  const std::string id = (*here.store().Create(Principal(), CageConfig(), absl::Now()))->id();
  const auto answered = [&id](Process& process) {
    return process.store().Find(id).value()->Facts().next_sequence_number;
  };
  EXPECT_EQ(answered(here), 0u);
  there.Open(id);
  there.Answer(MovingFrame(0));
  EXPECT_EQ(answered(here), 1u);
  EXPECT_EQ(here.store().List("", "", 9).value()[0]->Facts().fitted_frames, 1u);
  here.Open(id);
  EXPECT_EQ(here.next_sequence_number(), 1u);
  here.Answer(MovingFrame(1));
  there.Open(id);
  EXPECT_EQ(there.next_sequence_number(), 2u);
  EXPECT_EQ(there.store().Delete(id), absl::OkStatus());
  const SessionLease lease = here.store().Lease(id).value();  // its stream here does not know yet
  const auto refused = lease->Answer(MovingFrame(2), 2, nullptr);
  EXPECT_EQ(testing::ReasonOf(refused.status()), "SESSION_DELETED") << refused.status();
}

TEST(UnloadTest, AnUnloadedSessionGoesOnWithTheSameBits) {
  const testing::StoreFile kept_file, unloaded_file;
  Process kept(kept_file), unloaded(unloaded_file);
  for (Process* process : {&kept, &unloaded}) {
    process->Open((*process->store().Create(Principal(), CageConfig(), absl::Now()))->id());
  }
  for (uint64_t number = 0; number < 4; ++number) {
    const StoredFrame expected = kept.Answer(MovingFrame(number));
    const StoredFrame answer = unloaded.Answer(MovingFrame(number));
    EXPECT_EQ(answer.delta.checksum, expected.delta.checksum) << number;
    unloaded.store().Unload(absl::InfiniteFuture());
  }
}

TEST(UnloadTest, TakesOnlyWhatNobodyHolds) {
  const testing::StoreFile file;
  Process process(file);
  const std::string id = (*process.store().Create(Principal(), CageConfig(), absl::Now()))->id();
  {
    const auto held = process.store().Find(id).value();
    process.store().Unload(absl::InfiniteFuture());
    EXPECT_EQ(process.store().Find(id).value(), held);
  }
  process.store().Unload(absl::InfinitePast());
  const std::weak_ptr<SessionLedger> loaded = process.store().Find(id).value();
  EXPECT_FALSE(loaded.expired());
  process.store().Unload(absl::InfiniteFuture());
  EXPECT_TRUE(loaded.expired());
}

}  // namespace
}  // namespace cagefit::server
