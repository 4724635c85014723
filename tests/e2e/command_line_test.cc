// What a user meets before and around a fit.
#include <gmock/gmock.h>
#include <signal.h>

#include <filesystem>

#include "tests/e2e/program.h"

namespace cagefit::testing {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

TEST(CommandLineTest, HelpAndVersionAreNoErrors) {
  EXPECT_EQ(RunCagefit({"--help"}).exit_code, 0);
  EXPECT_THAT(RunCagefit({"--version"}).out, HasSubstr("cagefit "));
  const ProgramResult help = RunCagefit({"fit", "--help"});
  EXPECT_EQ(help.exit_code, 0);
  EXPECT_THAT(help.out, AllOf(HasSubstr("--template"), HasSubstr("--server")));
}

TEST(CommandLineTest, WrongUsageEndsWithTwoAndSaysWhatIsWrong) {
  const std::vector<std::vector<std::string>> wrong = {
      {},
      {"fitt"},
      {"fit"},
      {"fit", "x.ply", "--out", "o", "--radios", "1"},
      {"fit", "/nowhere/x.ply", "--out", "o", "--vertices", "10"},
      {"fit", "/etc/hostname", "--out", "o", "--vertices", "10"},
      {"fit", "x.ply", "--out", "o", "--vertices", "10", "--template", "c.obj"},
      {"fit", "x.ply", "--out", "o", "--vertices", "many"},
      {"fit", "x.ply", "--out", "o", "--vertices", "10", "--quick=maybe"},
      {"fit", "x.ply", "--out", "o", "--tolerance", "0.1"},
      {"fit", "x.ply", "--out", "o", "--tolerance", "fine"},
      {"refine", "c.obj", "--out", "m.obj", "--levels", "9"},
      {"render", "m.obj", "--out", "o", "--size", "0"},
      {"render", "m.obj", "--out", "o", "--cameras", "c.json", "--views", "3"},
      {"synth", "cube", "--out", "o"},
      {"session", "list", "extra"}};
  for (const auto& arguments : wrong) {
    const ProgramResult result = RunCagefit(arguments);
    EXPECT_EQ(result.exit_code, 2) << ::testing::PrintToString(arguments);
    EXPECT_THAT(result.err, HasSubstr("cagefit: ")) << ::testing::PrintToString(arguments);
  }
  EXPECT_THAT(RunCagefit({"fit", "/nowhere/x.ply", "--out", "o", "--vertices", "10"}).err,
              HasSubstr("/nowhere/x.ply: there is no such file"));
}

TEST(CommandLineTest, AFitNeedsATemplateOrACount) {
  const ProgramResult result = RunCagefit({"fit", "/etc", "--out", EmptyFolder("none")});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.err, HasSubstr("--template CAGE, or --vertices N"));
}

TEST(CommandLineTest, SettingsThatAServerRefusesAreWrongUsage) {
  const std::string folder = EmptyFolder("refused");
  ASSERT_EQ(
      RunCagefit({"synth", "blob", "--out", folder, "--frames", "1", "--points", "500"}).exit_code,
      0);
  const ProgramResult radius =
      RunCagefit({"fit", folder, "--vertices", "50", "--radius", "-1", "--out", folder + "/out"});
  EXPECT_EQ(radius.exit_code, 2);
  EXPECT_THAT(radius.err, HasSubstr("radius is -1; it must be from 0"));
  const ProgramResult nowhere = RunCagefit({"fit", folder, "--vertices", "50", "--out", "/proc/x"});
  EXPECT_EQ(nowhere.exit_code, 1);
  EXPECT_THAT(nowhere.err, HasSubstr("cannot be made"));
}

TEST(CommandLineTest, APresetIsWhereOtherSettingsStartFrom) {
  const std::string folder = EmptyFolder("preset");
  ASSERT_EQ(
      RunCagefit({"synth", "blob", "--out", folder, "--frames", "1", "--points", "500"}).exit_code,
      0);
  const ProgramResult result =
      RunCagefit({"fit", folder, "--vertices", "50", "--preset", "paper", "--max-iterations", "3",
                  "--keep-normals", "--remove-outliers", "--out", folder + "/out"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto fit = ReadJson(folder + "/out/report.json")["settings"]["options"]["fit"];
  EXPECT_EQ(fit["solver"], "SOLVER_ADAM");
  EXPECT_EQ(fit["sampling"], "SAMPLING_CONTROL_VERTICES");
  EXPECT_EQ(fit["max_iterations"], 3);
  EXPECT_EQ(fit["remove_outliers"], true);
  EXPECT_EQ(fit["repair_normals"], false);
}

TEST(CommandLineTest, NoServerEndsWithThreeAndNamesTheAddress) {
  const ProgramResult result = RunCagefit({"session", "list", "--server", "127.0.0.1:1"});
  EXPECT_EQ(result.exit_code, 3);
  EXPECT_THAT(result.err, HasSubstr("no server answers at 127.0.0.1:1"));
}

TEST(CommandLineTest, WorkThatFailsEndsWithOne) {
  const std::string folder = EmptyFolder("fails");
  WriteText(folder + "/broken.obj", "v 1 2\n");
  const ProgramResult refine =
      RunCagefit({"refine", folder + "/broken.obj", "--out", folder + "/m.obj"});
  EXPECT_EQ(refine.exit_code, 1);
  EXPECT_THAT(refine.err, HasSubstr(folder + "/broken.obj: line 1"));
  EXPECT_EQ(RunCagefit({"template", folder + "/broken.obj", "--vertices", "9", "--out", "x.obj"})
                .exit_code,
            1);
}

TEST(CommandLineTest, SynthIsTheSameForOneSeedAndOtherForAnother) {
  const std::string a = EmptyFolder("synth_a"), b = EmptyFolder("synth_b"),
                    c = EmptyFolder("synth_c");
  const std::vector<std::string> rest = {"--frames", "2", "--points", "500"};
  const auto synth = [&](const std::string& out, const std::string& seed) {
    std::vector<std::string> arguments = {"synth", "tube", "--out", out, "--seed", seed};
    arguments.insert(arguments.end(), rest.begin(), rest.end());
    EXPECT_EQ(RunCagefit(arguments).exit_code, 0);
    return ReadText(out + "/frame_0001.drc");
  };
  const std::string first = synth(a, "5");
  EXPECT_FALSE(first.empty());
  EXPECT_EQ(synth(b, "5"), first);
  EXPECT_NE(synth(c, "6"), first);
  EXPECT_TRUE(std::filesystem::exists(a + "/truth/frame_0001.ply"));
}

TEST(CommandLineTest, TemplateRefineAndEvaluateWorkTogether) {
  const std::string folder = EmptyFolder("together");
  ASSERT_EQ(
      RunCagefit({"synth", "blob", "--out", folder, "--frames", "1", "--points", "2000"}).exit_code,
      0);
  const std::string truth = folder + "/truth/frame_0000.ply", cage = folder + "/cage.obj";
  ASSERT_EQ(RunCagefit({"template", truth, "--vertices", "200", "--out", cage}).exit_code, 0);
  ASSERT_EQ(RunCagefit({"refine", cage, "--levels", "2", "--out", folder + "/fine.ply"}).exit_code,
            0);
  const ProgramResult self =
      RunCagefit({"evaluate", cage, folder + "/fine.ply", "--levels", "2", "--json"});
  ASSERT_EQ(self.exit_code, 0) << self.err;
  const auto same = nlohmann::json::parse(self.out);
  EXPECT_LT(same[0]["distances"]["hausdorff_percent"], 1e-9);
  const auto other = nlohmann::json::parse(RunCagefit({"evaluate", cage, truth, "--json"}).out);
  EXPECT_GT(other[0]["distances"]["target_to_fit"]["rms_percent"], 1e-3);
  EXPECT_LT(other[0]["distances"]["target_to_fit"]["rms_percent"], 1);
}

TEST(CommandLineTest, RendersThroughTheCamerasThatItWrote) {
  const std::string folder = EmptyFolder("render"), mesh = folder + "/truth/frame_0000.ply";
  ASSERT_EQ(
      RunCagefit({"synth", "blob", "--out", folder, "--frames", "1", "--points", "500"}).exit_code,
      0);
  const std::string first = folder + "/first", second = folder + "/second";
  const ProgramResult result =
      RunCagefit({"render", mesh, "--out", first, "--views", "3", "--size", "64"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  ASSERT_EQ(
      RunCagefit({"render", mesh, "--out", second, "--cameras", first + "/cameras.json"}).exit_code,
      0);
  for (const char* name : {"/silhouette/view_0002.png", "/depth/view_0002.pfm",
                           "/normals/view_0002.pfm", "/cameras.json"}) {
    EXPECT_FALSE(ReadText(first + name).empty()) << name;
    EXPECT_EQ(ReadText(first + name), ReadText(second + name)) << name;
  }
  EXPECT_EQ(ReadText(first + "/depth/view_0000.pfm").substr(0, 9), "Pf\n64 64\n");
}

TEST(CommandLineTest, RendersALimitSurfaceOrSaysWhatIsMissing) {
  const std::string folder = EmptyFolder("render_cage");
  WriteText(folder + "/cage.obj",
            "v 1 1 1\nv 1 -1 -1\nv -1 1 -1\nv -1 -1 1\nf 1 2 3\nf 1 3 4\nf 1 4 2\nf 2 4 3\n");
  const ProgramResult result = RunCagefit(
      {"render", folder + "/cage.obj", "--levels", "2", "--views", "1", "--out", folder + "/out"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("64 triangles in 1 views"));
  WriteText(folder + "/cloud.obj", "v 1 1 1\nv 1 -1 -1\n");
  const ProgramResult cloud = RunCagefit({"render", folder + "/cloud.obj", "--out", folder});
  EXPECT_EQ(cloud.exit_code, 1);
  EXPECT_THAT(cloud.err, HasSubstr("cloud.obj: it has no faces; rendering needs them"));
}

TEST(CommandLineTest, FlagsCountMoreThanVariablesAndThoseMoreThanTheFile) {
  const std::string folder = EmptyFolder("settings");
  ASSERT_EQ(
      RunCagefit({"synth", "blob", "--out", folder, "--frames", "1", "--points", "2000"}).exit_code,
      0);
  WriteText(folder + "/fit.ini", "max-iterations=3\nradius-factor=2.5\nfirst-stiffness=7\n");
  const std::vector<std::string> arguments = {"fit",        folder,
                                              "--vertices", "100",
                                              "--out",      folder + "/out",
                                              "--config",   folder + "/fit.ini",
                                              "--quick",    "--max-iterations",
                                              "5"};
  const ProgramResult result =
      RunCagefit(arguments, {"CAGEFIT_MAX_ITERATIONS=4", "CAGEFIT_RADIUS_FACTOR=3"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto fit = ReadJson(folder + "/out/report.json")["settings"]["options"]["fit"];
  EXPECT_EQ(fit["max_iterations"], 5);
  EXPECT_EQ(fit["radius_factor"], 3);
  EXPECT_EQ(fit["first_stiffness"], 7);
  WriteText(folder + "/fit.ini", "no-such-thing=3\n");
  const ProgramResult bad = RunCagefit(arguments);
  EXPECT_EQ(bad.exit_code, 2);
  EXPECT_THAT(bad.err, HasSubstr("no-such-thing"));
}

}  // namespace
}  // namespace cagefit::testing
