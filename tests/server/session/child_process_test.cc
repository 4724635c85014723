#include "server/session/child_process.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "server/session/error_detail.h"
#include "tests/server/session/life_line.h"

namespace cagefit::server {
namespace {

using ::testing::EndsWith;
using ::testing::HasSubstr;
using testing::LifeLine;
using ::testing::Not;

absl::StatusOr<ChildResult> RunScript(const std::string& script, const ChildLimits& limits = {},
                                      const CancelFn& cancelled = nullptr) {
  return RunChild({"/bin/sh", "-c", script}, limits, cancelled);
}

TEST(ChildProcessTest, ReturnsTheExitCode) {
  for (const int code : {0, 1, 42}) {
    const auto result = RunScript(absl::StrCat("exit ", code));
    ASSERT_TRUE(result.ok()) << result.status();
    EXPECT_EQ(result->exit_code, code);
    EXPECT_EQ(result->signal, 0);
  }
}

TEST(ChildProcessTest, ReturnsTheSignalThatEndedIt) {
  const auto result = RunScript("kill -SEGV $$");
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_EQ(result->exit_code, -1);
  EXPECT_EQ(result->signal, SIGSEGV);
}

TEST(ChildProcessTest, AProgramThatIsNotThereExitsWith127) {
  const auto result = RunChild({"/nowhere/program"}, {}, nullptr);
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_EQ(result->exit_code, 127);
}

TEST(ChildProcessTest, PassesArgumentsAsTheyAre) {
  const auto result =
      RunChild({"/bin/sh", "-c", "printf '%s|' \"$@\" >&2", "sh", "a b", "*", ""}, {}, nullptr);
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_EQ(result->last_stderr, "a b|*||");
}

TEST(ChildProcessTest, KeepsTheEndOfStderr) {
  const auto result = RunScript("echo first >&2; yes | head -c 100000 >&2; echo last >&2; exit 3");
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_EQ(result->exit_code, 3);
  EXPECT_THAT(result->last_stderr, EndsWith("last\n"));
  EXPECT_THAT(result->last_stderr, Not(HasSubstr("first")));
  EXPECT_LE(result->last_stderr.size(), 2000u);
}

// The child fills the pipe before it is read for the first time.
TEST(ChildProcessTest, AWriterWaitsForAReaderThatIsLate) {
  bool is_late = true;
  const auto result = RunScript("yes | head -c 1000000 >&2 && echo last >&2", {}, [&is_late] {
    if (std::exchange(is_late, false)) absl::SleepFor(absl::Milliseconds(200));
    return false;
  });
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_EQ(result->exit_code, 0);
  EXPECT_THAT(result->last_stderr, EndsWith("last\n"));
}

TEST(ChildProcessTest, HasNoInputAndNoFileOfItsParent) {
  const int inherited = open("/dev/null", O_RDONLY);  // without close-on-exec
  const auto result = RunScript("cat; ls /proc/self/fd | wc -w >&2");
  close(inherited);
  ASSERT_TRUE(result.ok()) << result.status();
  // 0, 1, 2, and the one that ls lists the folder with.
  EXPECT_THAT(result->last_stderr, HasSubstr("4"));
}

TEST(ChildProcessTest, StopsAtTheTimeLimit) {
  ChildLimits limits;
  limits.max_time = absl::Milliseconds(100);
  LifeLine life;
  const auto result =
      RunScript(absl::StrCat("exec 3>", life.path(), "; sleep 1000 & sleep 1000"), limits);
  EXPECT_TRUE(absl::IsResourceExhausted(result.status())) << result.status();
  EXPECT_EQ(DetailOf(result.status())->reason, "LIMIT_EXCEEDED");
  EXPECT_TRUE(life.AllWritersEnd());
}

TEST(ChildProcessTest, MemoryBeyondTheLimitIsRefused) {
  ChildLimits limits;
  limits.max_memory_bytes = int64_t{64} << 20;
  const std::string keep_it_all = "head -c 200000000 /dev/zero | tail -c 200000000 >/dev/null";
  const auto refused = RunScript(keep_it_all, limits);
  ASSERT_TRUE(refused.ok()) << refused.status();
  EXPECT_NE(refused->exit_code, 0);

  limits.max_memory_bytes = int64_t{1} << 30;
  const auto enough = RunScript(keep_it_all, limits);
  ASSERT_TRUE(enough.ok()) << enough.status();
  EXPECT_EQ(enough->exit_code, 0) << enough->last_stderr;
}

TEST(ChildProcessTest, CancelKillsTheWholeGroup) {
  LifeLine life;
  const auto result =
      RunScript(absl::StrCat("exec 3>", life.path(), "; sleep 1000 & echo >&3; wait"), {},
                [&life] { return life.Started(); });
  EXPECT_TRUE(absl::IsCancelled(result.status())) << result.status();
  EXPECT_TRUE(life.AllWritersEnd());
}

TEST(ChildProcessTest, NothingOfItOutlivesItsEnd) {
  LifeLine life;
  const auto result = RunScript(absl::StrCat("exec 3>", life.path(), "; sleep 1000 & exit 0"));
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_TRUE(life.AllWritersEnd());
}

}  // namespace
}  // namespace cagefit::server
