// Fits that break off and go on, and fits of sequences that are still being captured.
#include <gmock/gmock.h>
#include <signal.h>

#include <filesystem>
#include <regex>
#include <thread>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "client/io/geometry_file.h"
#include "tests/e2e/program.h"

namespace cagefit::testing {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr int kFrames = 10;

std::string Capture(int frames = kFrames) {
  const std::string folder = EmptyFolder("capture");
  EXPECT_EQ(RunCagefit({"synth", "blob", "--out", folder, "--frames", std::to_string(frames),
                        "--points", "20000"})
                .exit_code,
            0);
  return folder;
}

std::string FrameFile(const std::string& out, int number) {
  return absl::StrFormat("%s/frames/%04d.obj", out, number);
}

void ExpectSameFrames(const std::string& a, const std::string& b, int frames = kFrames) {
  for (int k = 0; k < frames; ++k) {
    ASSERT_TRUE(std::filesystem::exists(FrameFile(a, k))) << k;
    EXPECT_EQ(ReadText(FrameFile(a, k)), ReadText(FrameFile(b, k))) << k;
  }
  EXPECT_EQ(ReadText(a + "/cage.obj"), ReadText(b + "/cage.obj"));
}

// But for times, and for the bytes of deltas, of which some are key frames after a break.
void ExpectSameReports(const std::string& a, const std::string& b) {
  auto one = ReadJson(a + "/report.json"), other = ReadJson(b + "/report.json");
  for (auto* report : {&one, &other}) {
    for (auto& frame : (*report)["frames"]) {
      frame.erase("milliseconds");
      frame.erase("delta_bytes");
    }
    for (const char* key : {"seconds", "frames_per_second"}) (*report)["total"].erase(key);
  }
  EXPECT_EQ(one["frames"], other["frames"]);
  EXPECT_EQ(one["total"], other["total"]);
}

// A program as a shell starts it, its standard error in a file.
class ShellProgram {
 public:
  ShellProgram(const std::string& command, const std::string& folder)
      : err_file_(NewFile(folder)),
        program_("/bin/sh", {"-c", absl::StrCat("exec ", command, " 2>", err_file_)}) {}
  std::string ReadLine() { return program_.ReadLine(); }
  void Signal(int signal) const { program_.Signal(signal); }
  int Wait() { return program_.Wait(); }
  std::string err() const { return ReadText(err_file_); }
  // The command that it printed for going on.
  std::string Printed() const {
    std::smatch found;
    const std::string text = err();
    return std::regex_search(text, found, std::regex("\n  (.+)\n")) ? found[1].str() : "";
  }

 private:
  // Of each program its own: the command that one printed starts the next.
  static std::string NewFile(const std::string& folder) {
    static int count = 0;
    const std::string file = absl::StrCat(folder, "_err_", count++, ".txt");
    std::filesystem::remove(file);  // an earlier run's
    return file;
  }

  const std::string err_file_;
  RunningProgram program_;
};

std::string FitCommand(const std::string& capture, const std::string& out,
                       const std::string& more) {
  return absl::StrCat(CagefitProgram(), " fit ", capture, " --out ", out, " --quick ", more);
}

int RunShell(const std::string& command, const std::string& folder) {
  return ShellProgram(command, folder).Wait();
}

// Starts a fit, and sends it `signal` once it has printed `lines` frames.
void Break(ShellProgram* fit, int lines, int signal) {
  for (int k = 0; k < lines; ++k) ASSERT_THAT(fit->ReadLine(), HasSubstr("\"frame\":"));
  fit->Signal(signal);
}

class ResumeEndToEndTest : public ::testing::Test {
 protected:
  void SetUp() override {
    capture_ = Capture();
    whole_ = EmptyFolder("whole");
    ASSERT_EQ(RunShell(FitCommand(capture_, whole_, options_), whole_), 0);
  }
  std::string AtServer() const {
    return absl::StrCat(options_, " --name 'it'\\''s a rig' --json --server ", server_.address());
  }
  nlohmann::json Sessions() {
    return nlohmann::json::parse(
        RunCagefit({"session", "list", "--json", "--server", server_.address()}).out);
  }

  const std::string options_ = "--vertices 150";
  std::string capture_, whole_;
  ServerProgram server_;
};

TEST_F(ResumeEndToEndTest, TheCommandThatCtrlCPrintsGivesWhatAnUninterruptedFitGives) {
  const std::string out = EmptyFolder("interrupted");
  ShellProgram fit(FitCommand(capture_, out, AtServer()), out);
  Break(&fit, 3, SIGINT);
  EXPECT_EQ(fit.Wait(), 4);
  EXPECT_THAT(fit.err(), HasSubstr("interrupted; "));
  ASSERT_EQ(Sessions().size(), 1u);
  const std::string id = Sessions()[0]["session_id"];
  EXPECT_THAT(fit.Printed(), AllOf(HasSubstr("--session " + id), HasSubstr("'it'\\''s a rig'")));
  EXPECT_GT(ReadJson(out + "/report.json")["total"]["unanswered"], 0);

  EXPECT_EQ(RunShell(fit.Printed(), out), 0);
  ExpectSameFrames(whole_, out);
  ExpectSameReports(whole_, out);
  EXPECT_TRUE(Sessions().empty()) << "the session goes when its fit is done";
}

TEST_F(ResumeEndToEndTest, AnInterruptedContinuationGoesOnToo) {
  const std::string out = EmptyFolder("twice");
  ShellProgram first(FitCommand(capture_, out, AtServer()), out);
  Break(&first, 2, SIGINT);
  EXPECT_EQ(first.Wait(), 4);
  const std::string command = first.Printed();
  ShellProgram second(command, out);
  Break(&second, 2, SIGTERM);
  EXPECT_EQ(second.Wait(), 4);
  EXPECT_EQ(second.Printed(), command) << "one --session";
  EXPECT_EQ(RunShell(command, out), 0);
  ExpectSameFrames(whole_, out);
  ExpectSameReports(whole_, out);
}

TEST_F(ResumeEndToEndTest, AKilledFitGoesOnWithItsSession) {
  const std::string out = EmptyFolder("killed");
  ShellProgram fit(FitCommand(capture_, out, AtServer()), out);
  Break(&fit, 3, SIGKILL);
  EXPECT_EQ(fit.Wait(), -1);
  // A frame that was answered, but whose file did not come to be.
  std::filesystem::remove(FrameFile(out, 1));
  const std::string id = Sessions()[0]["session_id"];
  EXPECT_THAT(fit.err(), HasSubstr("session " + id)) << "it was told at the start";
  EXPECT_EQ(RunShell(FitCommand(capture_, out, absl::StrCat(AtServer(), " --session ", id)), out),
            0);
  ExpectSameFrames(whole_, out);
  ExpectSameReports(whole_, out);
}

TEST_F(ResumeEndToEndTest, RefusedAndUnreadableFramesKeepTheirNumbersAndReasons) {
  WriteText(capture_ + "/frame_0001.drc", "no Draco");
  std::filesystem::remove(capture_ + "/frame_0002.drc");
  std::filesystem::create_directory(capture_ + "/frame_0002.drc");  // cannot be read as a file
  const std::string whole = EmptyFolder("whole_with_gaps"), out = EmptyFolder("gaps");
  ASSERT_EQ(RunShell(FitCommand(capture_, whole, options_), whole), 4);
  ShellProgram fit(FitCommand(capture_, out, AtServer()), out);
  Break(&fit, 5, SIGINT);
  EXPECT_EQ(fit.Wait(), 4);
  EXPECT_EQ(RunShell(fit.Printed(), out), 4);
  ExpectSameReports(whole, out);
  const auto frames = ReadJson(out + "/report.json")["frames"];
  EXPECT_THAT(std::string(frames[2]["error"]["message"]), HasSubstr("frame_0002.drc: is a folder"));
  EXPECT_EQ(ReadText(FrameFile(whole, 9)), ReadText(FrameFile(out, 9)));
}

TEST_F(ResumeEndToEndTest, OtherFilesOrOptionsThanTheSessionsAreRefused) {
  const std::string out = EmptyFolder("changed");
  ShellProgram fit(FitCommand(capture_, out, AtServer()), out);
  Break(&fit, 3, SIGINT);
  EXPECT_EQ(fit.Wait(), 4);
  ShellProgram other_options(fit.Printed() + " --max-iterations 7", out);
  EXPECT_EQ(other_options.Wait(), 2);
  EXPECT_THAT(other_options.err(), HasSubstr("fit.max_iterations: 50 -> 7"));
  // One file more at the beginning: all others have other numbers than they had.
  const std::string added = capture_ + "/frame_.drc";
  std::filesystem::copy_file(capture_ + "/frame_0000.drc", added);
  ShellProgram other_files(fit.Printed(), out);
  EXPECT_EQ(other_files.Wait(), 4);
  EXPECT_THAT(other_files.err(), HasSubstr("the files are not those that session"));
  std::filesystem::remove(added);
  EXPECT_EQ(RunShell(fit.Printed(), out), 0) << "the session is as it was";
  ExpectSameFrames(whole_, out);
}

TEST_F(ResumeEndToEndTest, AServerThatStaysDeadIsGivenUpAndTheCommandPrinted) {
  const std::string out = EmptyFolder("dead");
  ShellProgram fit(FitCommand(capture_, out, AtServer() + " --give-up 1"), out);
  Break(&fit, 3, 0);
  server_.program().Signal(SIGKILL);
  EXPECT_EQ(fit.Wait(), 4);
  EXPECT_THAT(fit.err(), AllOf(HasSubstr("trying again"), HasSubstr("tried again for")));
  EXPECT_THAT(fit.Printed(), HasSubstr("--session "));
  EXPECT_EQ(RunShell(fit.Printed(), out), 3) << "no server at all";
}

TEST_F(ResumeEndToEndTest, AllFramesOfASessionArePulledLater) {
  const std::string out = EmptyFolder("kept"), pulled = EmptyFolder("pulled");
  ASSERT_EQ(RunShell(FitCommand(capture_, out, AtServer() + " --keep-session"), out), 0);
  const std::string id = Sessions()[0]["session_id"];
  const ProgramResult result =
      RunCagefit({"session", "pull", id, "--frames", pulled, "--server", server_.address()});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  for (int k = 0; k < kFrames; ++k) {
    EXPECT_EQ(ReadText(absl::StrFormat("%s/%04d.obj", pulled, k)), ReadText(FrameFile(whole_, k)));
  }
  const auto report = ReadJson(pulled + "/report.json"), whole = ReadJson(whole_ + "/report.json");
  ASSERT_EQ(report["frames"].size(), static_cast<size_t>(kFrames));
  EXPECT_EQ(report["frames"][7]["final_energies"], whole["frames"][7]["final_energies"]);
  EXPECT_EQ(report["total"]["worst_rms_percent"], whole["total"]["worst_rms_percent"]);
  EXPECT_EQ(RunCagefit({"session", "pull", id, "--server", server_.address()}).exit_code, 2);
}

TEST_F(ResumeEndToEndTest, WithoutAServerTheCommandStartsAgainAtTheFirstMissingFrame) {
  const std::string out = EmptyFolder("inside");
  ShellProgram fit(FitCommand(capture_, out, options_ + " --json"), out);
  Break(&fit, 3, SIGINT);
  EXPECT_EQ(fit.Wait(), 4);
  EXPECT_THAT(fit.err(), HasSubstr("the session went with the server inside this program"));
  const int fitted = ReadJson(out + "/report.json")["total"]["fitted"];
  EXPECT_THAT(fit.Printed(), HasSubstr(absl::StrCat("--from-frame ", fitted)));
  const std::string before = ReadText(FrameFile(out, fitted - 1));
  EXPECT_EQ(RunShell(fit.Printed(), out), 0);
  EXPECT_EQ(ReadText(FrameFile(out, fitted - 1)), before);
  const auto report = ReadJson(out + "/report.json");
  ASSERT_EQ(report["frames"].size(), static_cast<size_t>(kFrames - fitted));
  EXPECT_EQ(report["frames"][0]["frame"], fitted);
  EXPECT_EQ(report["settings"]["started_from"], FrameFile(out, fitted - 1));
  EXPECT_LT(report["total"]["worst_rms_percent"], 0.3);
  const auto first = client::ReadControlMesh(FrameFile(out, 0));
  const auto last = client::ReadControlMesh(FrameFile(out, kFrames - 1));
  ASSERT_TRUE(first.ok() && last.ok());
  EXPECT_EQ(first->triangles(), last->triangles()) << "one connectivity";
}

TEST_F(ResumeEndToEndTest, FromAFrameWithoutAnEarlierMeshTheTemplateIsTheUsualOne) {
  const std::string out = EmptyFolder("from");
  ASSERT_EQ(RunShell(FitCommand(capture_, out, options_ + " --from-frame 8"), out), 0);
  EXPECT_FALSE(std::filesystem::exists(FrameFile(out, 7)));
  EXPECT_TRUE(std::filesystem::exists(FrameFile(out, 8)));
  EXPECT_EQ(ReadText(out + "/cage.obj"), ReadText(FrameFile(out, 9)));
  EXPECT_EQ(ReadJson(out + "/report.json")["total"]["frames"], 2);
  ShellProgram beyond(FitCommand(capture_, out, options_ + " --from-frame 10"), out);
  EXPECT_EQ(beyond.Wait(), 2);
  EXPECT_THAT(beyond.err(), HasSubstr("--from-frame is 10; the input has frames 0 to 9"));
}

TEST_F(ResumeEndToEndTest, AFollowedFolderIsFittedAsItsFilesAreCompleted) {
  const std::string live = EmptyFolder("live"), out = EmptyFolder("followed");
  const auto file = [](const std::string& folder, int k) {
    return absl::StrFormat("%s/frame_%04d.drc", folder, k);
  };
  // The settling time is far beyond the test's: renamed files count at once.
  ShellProgram fit(FitCommand(live, out, AtServer() + " --follow --follow-settle 600"), out);
  // Until then it does not watch the folder: a file that is there before may be half written.
  while (!absl::StrContains(fit.err(), "cagefit: follows ")) std::this_thread::yield();
  for (int k = 0; k < kFrames; ++k) {
    std::filesystem::copy_file(file(capture_, k), live + "/.part");
    std::filesystem::rename(live + "/.part", file(live, k));
    ASSERT_THAT(fit.ReadLine(), HasSubstr(absl::StrCat("\"frame\":", k, ","))) << fit.err();
  }
  fit.Signal(SIGINT);  // the way to end it
  EXPECT_EQ(fit.Wait(), 0) << fit.err();
  ExpectSameFrames(whole_, out);
  const auto report = ReadJson(out + "/report.json");
  EXPECT_EQ(report["total"]["fitted"], kFrames);
  EXPECT_EQ(report["frames"][3]["file"], file(live, 3));
}

TEST_F(ResumeEndToEndTest, AFollowedFolderThatStaysIdleIsDone) {
  const std::string out = EmptyFolder("idle");
  ShellProgram fit(
      FitCommand(capture_, out, options_ + " --follow --follow-settle 0.1 --follow-idle 0.5"), out);
  EXPECT_EQ(fit.Wait(), 0) << fit.err();
  ExpectSameFrames(whole_, out);
  EXPECT_EQ(RunCagefit({"fit", capture_, capture_, "--out", out, "--vertices", "9", "--follow"})
                .exit_code,
            2);
}

}  // namespace
}  // namespace cagefit::testing
