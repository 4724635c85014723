// `cagefit fit --takes`: a farm's calls, repeated and killed.
#include <gmock/gmock.h>
#include <signal.h>

#include <filesystem>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "absl/time/time.h"
#include "tests/e2e/program.h"

namespace cagefit::testing {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr int kFrames = 8;

class TakesTest : public ::testing::Test {
 protected:
  void SetUp() override {
    captures_ = EmptyFolder("takes");
    for (const char* name : {"run", "walk"}) {
      const ProgramResult made = RunCagefit({"synth", "blob", "--out", captures_ + "/" + name,
                                             "--frames", absl::StrCat(kFrames), "--points", "6000",
                                             "--seed", std::string(name) == "run" ? "1" : "2"});
      ASSERT_EQ(made.exit_code, 0) << made.err;
    }
    cage_ = captures_ + "/cage.obj";
    const ProgramResult made = RunCagefit(
        {"template", captures_ + "/run/frame_0000.drc", "--vertices", "150", "--out", cage_});
    ASSERT_EQ(made.exit_code, 0) << made.err;
  }

  std::vector<std::string> Arguments(const std::string& out,
                                     const std::vector<std::string>& more = {}) const {
    std::vector<std::string> arguments = {
        "fit",        "--takes", captures_ + "/walk", captures_ + "/run", "--out", out, "--quick",
        "--vertices", "150"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
  }

  std::string captures_, cage_;
};

std::string Frame(const std::string& out, const std::string& take, int k) {
  return absl::StrCat(out, "/", take, "/frames/000", k, ".obj");
}

void ExpectSameFrames(const std::string& a, const std::string& b) {
  for (const char* take : {"run", "walk"}) {
    for (int k = 0; k < kFrames; ++k) {
      EXPECT_EQ(ReadText(Frame(a, take, k)), ReadText(Frame(b, take, k))) << take << " " << k;
    }
  }
}

TEST_F(TakesTest, WhatIsDoneIsNotDoneAgain) {
  const std::string out = EmptyFolder("takes_out");
  const ProgramResult first = RunCagefit(Arguments(out));
  ASSERT_EQ(first.exit_code, 0) << first.err;
  EXPECT_THAT(first.err, AllOf(HasSubstr("take run: begins, 8 frames"),
                               HasSubstr("take walk: 8 of 8 frames fitted"),
                               HasSubstr("2 of 2 takes are done")));
  EXPECT_FALSE(fs::exists(out + "/run/session.db"));
  EXPECT_EQ(ReadJson(out + "/run/report.json")["total"]["fitted"], kFrames);

  const auto written = fs::last_write_time(Frame(out, "run", 7));
  const ProgramResult again = RunCagefit(Arguments(out));
  EXPECT_EQ(again.exit_code, 0);
  EXPECT_THAT(again.err, AllOf(HasSubstr("take run: done before"), Not(HasSubstr("begins"))));
  EXPECT_EQ(fs::last_write_time(Frame(out, "run", 7)), written);

  const ProgramResult other = RunCagefit(Arguments(out, {"--arap-weight", "0.01"}));
  EXPECT_EQ(other.exit_code, 0);
  EXPECT_THAT(other.err, HasSubstr("take run: begins, 8 frames"));
}

TEST_F(TakesTest, AKilledCallIsGoneOnWithToTheBit) {
  const std::string whole = EmptyFolder("takes_whole"), killed = EmptyFolder("takes_killed");
  ASSERT_EQ(RunCagefit(Arguments(whole)).exit_code, 0);
  {
    RunningProgram program(CagefitProgram(), Arguments(killed));
    while (!fs::exists(Frame(killed, "run", 2))) absl::SleepFor(absl::Milliseconds(5));
    program.Signal(SIGKILL);
    program.Wait();
  }
  const ProgramResult rest = RunCagefit(Arguments(killed));
  ASSERT_EQ(rest.exit_code, 0) << rest.err;
  EXPECT_THAT(rest.err, AllOf(HasSubstr("take run: goes on"), HasSubstr("take walk: begins"),
                              Not(HasSubstr("frame 1 of 8: RMS 0.0000"))));
  ExpectSameFrames(whole, killed);
}

TEST_F(TakesTest, AnInterruptedCallSaysThatTheSameCommandGoesOn) {
  const std::string out = EmptyFolder("takes_interrupted");
  {
    RunningProgram program(CagefitProgram(), Arguments(out));
    while (!fs::exists(Frame(out, "run", 2))) absl::SleepFor(absl::Milliseconds(5));
    program.Signal(SIGTERM);
    EXPECT_EQ(program.Wait(), 4);
  }
  EXPECT_TRUE(fs::exists(out + "/run/session.db"));
  EXPECT_EQ(RunCagefit(Arguments(out)).exit_code, 0);
}

TEST_F(TakesTest, ASessionThatAServerNoLongerHasBeginsAnew) {
  const std::string out = EmptyFolder("takes_gone");
  std::string address;
  {
    ServerProgram server;
    RunningProgram program(CagefitProgram(),
                           Arguments(out, {"--server", server.address(), "--give-up", "1"}));
    while (!fs::exists(Frame(out, "run", 2))) absl::SleepFor(absl::Milliseconds(5));
    program.Signal(SIGTERM);
    EXPECT_EQ(program.Wait(), 4);
    address = server.address();
  }
  EXPECT_EQ(RunCagefit(Arguments(out, {"--server", address, "--give-up", "1"})).exit_code, 3);
  ServerProgram server({"--listen", address});
  const ProgramResult fit = RunCagefit(Arguments(out, {"--server", address}));
  EXPECT_EQ(fit.exit_code, 0) << fit.err;
  EXPECT_THAT(fit.err, HasSubstr("take run: its session is gone; it begins anew"));
}

TEST_F(TakesTest, ABadTakeDoesNotHoldUpTheOthers) {
  WriteText(EmptyFolder("takes/broken") + "/frame.ply", "not a mesh");
  const std::string out = EmptyFolder("takes_bad");
  std::vector<std::string> arguments = Arguments(out);
  arguments.push_back(captures_ + "/broken");
  const ProgramResult fit = RunCagefit(arguments);
  EXPECT_EQ(fit.exit_code, 4);
  EXPECT_THAT(fit.err,
              AllOf(HasSubstr("frame.ply was refused"), HasSubstr("2 of 3 takes are done")));
}

TEST_F(TakesTest, FramesOutsideARangeAreLeftOut) {
  const std::string out = EmptyFolder("takes_range");
  const ProgramResult fit = RunCagefit(Arguments(out, {"--from-frame", "2", "--to-frame", "4"}));
  ASSERT_EQ(fit.exit_code, 0) << fit.err;
  EXPECT_EQ(ReadJson(out + "/walk/report.json")["total"]["frames"], 3);
  EXPECT_TRUE(fs::exists(Frame(out, "walk", 2)) && fs::exists(Frame(out, "walk", 4)));
  EXPECT_FALSE(fs::exists(Frame(out, "walk", 1)) || fs::exists(Frame(out, "walk", 5)));
  EXPECT_EQ(RunCagefit(Arguments(out, {"--to-frame", "8"})).exit_code, 2);
}

}  // namespace
}  // namespace cagefit::testing
