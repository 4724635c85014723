#include "server/session/session_store.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <optional>
#include <set>

#include "core/base/status.h"
#include "server/session/session_memory.h"
#include "tests/server/session/session_fixture.h"
#include "tests/support/masks.h"

namespace cagefit::server {
namespace {

using cagefit::testing::SmallCamera;
using testing::CageConfig;
using ::testing::HasSubstr;
using testing::ReasonOf;

class SessionStoreTest : public ::testing::Test {
 protected:
  SessionStore MakeStore(const SessionStore::Limits& limits = {}) {
    return SessionStore(limits, &journal_, &templates_, testing::NoTime);
  }
  MemoryJournal journal_;
  testing::FakeTemplates templates_;
};

TEST_F(SessionStoreTest, FindsWhatItCreated) {
  SessionStore store = MakeStore();
  const auto created = store.Create(Principal(), CageConfig(), absl::FromUnixSeconds(5));
  ASSERT_TRUE(created.ok()) << created.status();
  const auto found = store.Find((*created)->id());
  ASSERT_TRUE(found.ok()) << found.status();
  EXPECT_EQ(*found, *created);
  EXPECT_EQ((*found)->config().name, "a test");
  EXPECT_EQ((*found)->created(), absl::FromUnixSeconds(5));
}

TEST_F(SessionStoreTest, AnUnknownSessionIsNotFoundAndNamed) {
  SessionStore store = MakeStore();
  for (const absl::Status& status :
       {store.Find("nobody").status(), store.Delete("nobody"), store.Lease("nobody").status()}) {
    EXPECT_TRUE(absl::IsNotFound(status)) << status;
    EXPECT_THAT(std::string(status.message()), HasSubstr("nobody"));
    EXPECT_EQ(ReasonOf(status), "NO_SESSION");
  }
}

TEST_F(SessionStoreTest, ListsPagesInOrderOfId) {
  SessionStore store = MakeStore();
  std::set<std::string> ids;
  for (int k = 0; k < 7; ++k)
    ids.insert((*store.Create(Principal(), CageConfig(), absl::UnixEpoch()))->id());
  std::vector<std::string> listed;
  std::string after;
  for (const size_t expected : {3u, 3u, 1u, 0u}) {
    const auto page = store.List("", after, 3).value();
    ASSERT_EQ(page.size(), expected);
    for (const auto& ledger : page) listed.push_back(ledger->id());
    after = listed.back();
  }
  EXPECT_EQ(listed, std::vector<std::string>(ids.begin(), ids.end()));
}

TEST_F(SessionStoreTest, ALeaseExcludesAnotherUntilItEnds) {
  SessionStore store = MakeStore();
  const std::string id = (*store.Create(Principal(), CageConfig(), absl::UnixEpoch()))->id();
  {
    const auto lease = store.Lease(id);
    ASSERT_TRUE(lease.ok()) << lease.status();
    EXPECT_EQ((*lease)->ledger()->id(), id);
    EXPECT_TRUE(absl::IsUnavailable(store.Lease(id).status()));
  }
  EXPECT_TRUE(store.Lease(id).ok());
}

TEST_F(SessionStoreTest, AMovedLeaseEndsOnce) {
  SessionStore store = MakeStore();
  const std::string id = (*store.Create(Principal(), CageConfig(), absl::UnixEpoch()))->id();
  std::optional<SessionLease> lease(store.Lease(id).value());
  std::optional<SessionLease> moved(*std::move(lease));
  lease.reset();
  EXPECT_TRUE(absl::IsUnavailable(store.Lease(id).status()));
  moved.reset();
  EXPECT_TRUE(store.Lease(id).ok());
}

TEST_F(SessionStoreTest, LeasesOfDifferentSessionsAreIndependent) {
  SessionStore store = MakeStore();
  const auto a = store.Lease((*store.Create(Principal(), CageConfig(), absl::UnixEpoch()))->id());
  const auto b = store.Lease((*store.Create(Principal(), CageConfig(), absl::UnixEpoch()))->id());
  EXPECT_TRUE(a.ok());
  EXPECT_TRUE(b.ok());
}

TEST_F(SessionStoreTest, DeletingEndsTheStreamButNotTheLease) {
  SessionStore store = MakeStore();
  const auto ledger = *store.Create(Principal(), CageConfig(), absl::UnixEpoch());
  absl::Status ended;
  ASSERT_TRUE(ledger->OpenStream([&ended](const absl::Status& status) { ended = status; }).ok());
  const auto lease = store.Lease(ledger->id());
  ASSERT_TRUE(lease.ok()) << lease.status();

  EXPECT_EQ(store.Delete(ledger->id()), absl::OkStatus());

  EXPECT_EQ(ReasonOf(ended), "SESSION_DELETED");
  EXPECT_TRUE(absl::IsNotFound(store.Find(ledger->id()).status()));
  EXPECT_TRUE(absl::IsNotFound(store.Delete(ledger->id())));
  EXPECT_TRUE(store.List("", "", 10)->empty());
  EXPECT_EQ((*lease)->ledger(), ledger);
}

TEST_F(SessionStoreTest, OpensASessionThatAnotherProcessHasWritten) {
  SessionStore here = MakeStore(), elsewhere = MakeStore();
  const std::string id = (*here.Create(Principal(), CageConfig(), absl::UnixEpoch()))->id();
  const auto none = [](const absl::Status&) {};
  ASSERT_TRUE(here.OpenStream(id, none).ok());
  const auto taken = elsewhere.OpenStream(id, none);
  ASSERT_TRUE(taken.ok()) << taken.status();
  auto answer = std::make_shared<StoredFrame>();
  ASSERT_TRUE(taken->ledger->Append(taken->opening.epoch, answer, std::nullopt).ok());

  const auto back = here.OpenStream(id, none);
  ASSERT_TRUE(back.ok()) << back.status();
  EXPECT_EQ(back->opening.next_sequence_number, 1u);
  EXPECT_GT(back->opening.epoch, taken->opening.epoch);
  EXPECT_EQ(here.Find(id).value(), back->ledger);
}

TEST_F(SessionStoreTest, ExpiresWhatNobodyUsesButNoSessionWithAStream) {
  SessionStore store = MakeStore();
  const std::string unused = (*store.Create(Principal(), CageConfig(), absl::UnixEpoch()))->id();
  const std::string streaming = (*store.Create(Principal(), CageConfig(), absl::UnixEpoch()))->id();
  ASSERT_TRUE(store.OpenStream(streaming, [](const absl::Status&) {}).ok());
  EXPECT_EQ(store.Attached(), std::vector<std::string>{streaming});
  ASSERT_TRUE(journal_.Touch({streaming}, absl::UnixEpoch()).ok());
  EXPECT_EQ(store.Expire(absl::FromUnixSeconds(-1)).value(), 0);
  EXPECT_EQ(store.Expire(absl::FromUnixSeconds(1)).value(), 1);
  EXPECT_TRUE(absl::IsNotFound(store.Find(unused).status()));
  EXPECT_TRUE(store.Find(streaming).ok());
}

TEST_F(SessionStoreTest, AJournalInMemoryKeepsItsSessionsThere) {
  SessionStore store = MakeStore();
  const auto created = store.Create(Principal(), CageConfig(), absl::UnixEpoch());
  store.Unload(absl::InfiniteFuture());
  EXPECT_EQ(store.Find((*created)->id()).value(), *created);
}

TEST_F(SessionStoreTest, RefusesMoreSessionsThanItsLimit) {
  SessionStore::Limits limits;
  limits.max_sessions = 2;
  SessionStore store = MakeStore(limits);
  const std::string first = (*store.Create(Principal(), CageConfig(), absl::UnixEpoch()))->id();
  ASSERT_TRUE(store.Create(Principal(), CageConfig(), absl::UnixEpoch()).ok());
  const absl::Status refused = store.Create(Principal(), CageConfig(), absl::UnixEpoch()).status();
  EXPECT_TRUE(absl::IsResourceExhausted(refused)) << refused;
  EXPECT_EQ(refused.message(), "sessions is 3; the limit is 2");
  ASSERT_TRUE(store.Delete(first).ok());
  EXPECT_TRUE(store.Create(Principal(), CageConfig(), absl::UnixEpoch()).ok());
}

TEST_F(SessionStoreTest, RefusesMoreControlVerticesThanItsLimit) {
  SessionStore::Limits limits;
  limits.session.max_control_vertices = 41;
  SessionStore store = MakeStore(limits);
  SessionConfig wish;
  wish.make_template.vertices = 42;
  for (const SessionConfig& config : {CageConfig(), wish}) {
    const absl::Status refused = store.Create(Principal(), config, absl::UnixEpoch()).status();
    EXPECT_TRUE(absl::IsResourceExhausted(refused)) << refused;
    EXPECT_EQ(refused.message(), "control vertices is 42; the limit is 41");
  }
}

TEST_F(SessionStoreTest, RefusesABadConfig) {
  SessionStore store = MakeStore();
  SessionConfig config = CageConfig();
  config.quantum = 1;
  EXPECT_TRUE(
      absl::IsInvalidArgument(store.Create(Principal(), config, absl::UnixEpoch()).status()));
}

TEST_F(SessionStoreTest, RefusesATemplateWhereNoneCanBeMade) {
  SessionStore store = MakeStore();
  templates_.available = absl::FailedPreconditionError("install it");
  SessionConfig wish;
  wish.make_template.vertices = 42;
  EXPECT_EQ(store.Create(Principal(), wish, absl::UnixEpoch()).status(), templates_.available);
  EXPECT_TRUE(store.Create(Principal(), CageConfig(), absl::UnixEpoch()).ok());
}

TEST_F(SessionStoreTest, CamerasWithTooManyPixelsAreExhaustion) {
  testing::FakeTemplates templates;
  SessionStore::Limits limits;
  limits.session.max_camera_pixels = 24;
  MemoryJournal journal;
  SessionStore store(limits, &journal, &templates, testing::NoTime);
  SessionConfig config = testing::CageConfig();
  config.cameras = {SmallCamera("left"), SmallCamera("right")};
  EXPECT_TRUE(store.Create(Principal(), config, absl::UnixEpoch()).ok());
  config.cameras.push_back(SmallCamera("front"));
  const absl::Status status = store.Create(Principal(), config, absl::UnixEpoch()).status();
  EXPECT_TRUE(absl::IsResourceExhausted(status)) << status;
  EXPECT_EQ(DetailOf(status)->value, "36");
}

// ---- Memory ----

class SessionMemoryTest : public SessionStoreTest {
 protected:
  // Room for `models` models of the test's cage and frames.
  SessionStore StoreFor(int models) {
    account_.emplace("memory of sessions", models * ModelBytes(CageConfig(), 42, 500) + (1 << 20));
    SessionStore::Limits limits;
    limits.memory = &*account_;
    return MakeStore(limits);
  }
  std::string Create(SessionStore* store) {
    return (*store->Create(Principal(), CageConfig(), absl::UnixEpoch()))->id();
  }
  // Fits the next frame.
  static absl::Status Fit(SessionStore* store, const std::string& id) {
    ASSIGN_OR_RETURN(const auto opened, store->OpenStream(id, [](const absl::Status&) {}));
    ASSIGN_OR_RETURN(SessionLease lease, store->Lease(id));
    RETURN_IF_ERROR(lease.Reserve(SessionLease::Work::kFit, 500));
    return lease
        ->Answer(testing::MovingFrame(opened.opening.next_sequence_number), opened.opening.epoch,
                 nullptr)
        .status();
  }
  static int64_t BytesOf(SessionStore* store, const std::string& id) {
    return (*store->Find(id))->Facts().memory_bytes;
  }

  std::optional<MemoryAccount> account_;
};

TEST_F(SessionMemoryTest, ASessionHoldsMoreOnceItHasAModelAndNothingOnceItIsGone) {
  SessionStore store = StoreFor(1);
  const std::string id = Create(&store);
  const int64_t idle = account_->taken();
  EXPECT_GT(idle, 0);
  EXPECT_EQ(BytesOf(&store, id), idle);
  ASSERT_EQ(Fit(&store, id), absl::OkStatus());
  EXPECT_GT(account_->taken(), idle + ModelBytes(CageConfig(), 42, 500) / 2);
  EXPECT_EQ(BytesOf(&store, id), account_->taken());
  ASSERT_TRUE(store.Delete(id).ok());
  EXPECT_EQ(account_->taken(), 0);
}

TEST_F(SessionMemoryTest, AFitTakesItsMemoryFromTheModelThatWasUsedLeastRecently) {
  SessionStore store = StoreFor(2);
  const std::string a = Create(&store), b = Create(&store), c = Create(&store);
  for (const std::string& id : {a, b, c}) ASSERT_EQ(Fit(&store, id), absl::OkStatus());
  const int64_t model = ModelBytes(CageConfig(), 42, 500);
  EXPECT_LT(BytesOf(&store, a), model);
  EXPECT_GE(BytesOf(&store, c), model);
  EXPECT_FALSE((*store.Lease(a))->has_model());
  EXPECT_TRUE((*store.Lease(c))->has_model());
  ASSERT_EQ(Fit(&store, a), absl::OkStatus()) << "it gets another one";
}

TEST_F(SessionMemoryTest, AModelInUseIsNotTaken) {
  SessionStore store = StoreFor(1);
  const std::string a = Create(&store), b = Create(&store);
  ASSERT_EQ(Fit(&store, a), absl::OkStatus());
  {
    const auto lease = store.Lease(a);
    ASSERT_TRUE(lease.ok());
    const absl::Status refused = Fit(&store, b);
    EXPECT_TRUE(absl::IsResourceExhausted(refused)) << refused;
    EXPECT_EQ(DetailOf(refused)->field, "memory of sessions");
    EXPECT_GT(DetailOf(refused)->retry_after, absl::ZeroDuration());
  }
  EXPECT_EQ(Fit(&store, b), absl::OkStatus());
}

TEST_F(SessionMemoryTest, ASessionThatHasNoRoomIsNotCreated) {
  account_.emplace("memory of sessions", 1000);
  SessionStore::Limits limits;
  limits.memory = &*account_;
  SessionStore store = MakeStore(limits);
  const auto refused = store.Create(Principal(), CageConfig(), absl::UnixEpoch());
  EXPECT_TRUE(absl::IsResourceExhausted(refused.status())) << refused.status();
  EXPECT_EQ(journal_.Count().value(), 0);
  EXPECT_EQ(account_->taken(), 0);
}

}  // namespace
}  // namespace cagefit::server
