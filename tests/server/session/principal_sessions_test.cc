#include "server/session/principal_sessions.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "absl/strings/str_replace.h"
#include "server/store/memory_journal.h"
#include "tests/server/session/session_fixture.h"

namespace cagefit::server {
namespace {

using testing::CageConfig;
using ::testing::HasSubstr;
using testing::ReasonOf;

class PrincipalSessionsTest : public ::testing::Test {
 protected:
  PrincipalSessions Of(const std::string& name, const Quotas& quotas = Quotas()) {
    auto principal = std::make_shared<Principal>();
    principal->name = name;
    principal->quotas = quotas;
    return PrincipalSessions(&store_, std::move(principal));
  }
  static std::string NewId(const PrincipalSessions& sessions) {
    return (*sessions.Create(CageConfig(), absl::UnixEpoch()))->id();
  }

  testing::FakeTemplates templates_;
  MemoryJournal journal_;
  SessionStore store_{SessionStore::Limits(), &journal_, &templates_, testing::NoTime};
};

TEST_F(PrincipalSessionsTest, ASessionBelongsToWhoMadeIt) {
  const PrincipalSessions north = Of("north");
  const std::string id = NewId(north);
  EXPECT_EQ((*north.Find(id))->owner(), "north");
  EXPECT_TRUE(north.Lease(id).ok());
  EXPECT_EQ(north.List("", 10)->size(), 1u);
  EXPECT_TRUE(north.Delete(id).ok());
}

TEST_F(PrincipalSessionsTest, AnothersSessionIsAsOneThatDoesNotExist) {
  const std::string id = NewId(Of("north"));
  for (const char* name : {"south", ""}) {
    const PrincipalSessions other = Of(name);
    const std::string unknown = "0123456789abcdef0123456789abcdef";
    const std::vector<std::pair<absl::Status, absl::Status>> pairs = {
        {other.Find(id).status(), other.Find(unknown).status()},
        {other.Lease(id).status(), other.Lease(unknown).status()},
        {other.Delete(id), other.Delete(unknown)},
        {other.OpenStream(id, [](const absl::Status&) {}).status(),
         other.OpenStream(unknown, [](const absl::Status&) {}).status()}};
    for (const auto& [foreign, missing] : pairs) {
      EXPECT_TRUE(absl::IsNotFound(foreign)) << foreign;
      EXPECT_EQ(foreign.message(), absl::StrReplaceAll(missing.message(), {{unknown, id}}));
      EXPECT_EQ(ReasonOf(foreign), ReasonOf(missing));
    }
    EXPECT_TRUE(other.List("", 10)->empty());
  }
  EXPECT_TRUE(Of("north").Find(id).ok());
}

TEST_F(PrincipalSessionsTest, APageIsFilledWithOwnSessionsOnly) {
  const PrincipalSessions north = Of("north"), south = Of("south");
  for (int k = 0; k < 5; ++k) {
    NewId(north);
    NewId(south);
  }
  const auto page = north.List("", 3).value();
  ASSERT_EQ(page.size(), 3u);
  EXPECT_EQ(north.List(page.back()->id(), 3)->size(), 2u);
}

TEST_F(PrincipalSessionsTest, TheQuotaOfSessionsCountsOwnOnesOnly) {
  Quotas quotas;
  quotas.sessions = 2;
  const PrincipalSessions north = Of("north", quotas);
  NewId(Of("south"));
  const std::string first = NewId(north);
  NewId(north);
  const absl::Status refused = north.Create(CageConfig(), absl::UnixEpoch()).status();
  EXPECT_TRUE(absl::IsResourceExhausted(refused)) << refused;
  EXPECT_EQ(refused.message(), "sessions of north is 3; the limit is 2");
  EXPECT_TRUE(Of("south").Create(CageConfig(), absl::UnixEpoch()).ok());
  ASSERT_TRUE(north.Delete(first).ok());
  EXPECT_TRUE(north.Create(CageConfig(), absl::UnixEpoch()).ok());
}

TEST_F(PrincipalSessionsTest, ARateThatIsExceededIsExhaustionUntilItIsMadeUpFor) {
  Quotas quotas;
  quotas.bytes_per_second = 1000;
  const PrincipalSessions north = Of("north", quotas);
  EXPECT_EQ(north.CheckRate(), absl::OkStatus());
  EXPECT_GT(north.Receive(1'000'000), absl::Seconds(900));
  const absl::Status refused = north.CheckRate();
  EXPECT_TRUE(absl::IsResourceExhausted(refused)) << refused;
  EXPECT_EQ(ReasonOf(refused), "RATE_EXCEEDED");
  EXPECT_GT(DetailOf(refused)->retry_after, absl::Seconds(900));
  EXPECT_THAT(std::string(refused.message()), HasSubstr("1000 of north; try again in 999 s"));
}

TEST_F(PrincipalSessionsTest, WithoutAQuotaNothingWaits) {
  const PrincipalSessions north = Of("north");
  EXPECT_EQ(north.Receive(int64_t{1} << 60), absl::ZeroDuration());
  EXPECT_EQ(north.CheckRate(), absl::OkStatus());
  int submitted = 0;
  for (int k = 0; k < 3; ++k) {
    EXPECT_TRUE(north
                    .RunFit(
                        [&submitted](const FitShare::Task&) {
                          ++submitted;
                          return absl::OkStatus();
                        },
                        [] {}, [](const absl::Status&) {})
                    .ok());
  }
  EXPECT_EQ(submitted, 3);
}

}  // namespace
}  // namespace cagefit::server
