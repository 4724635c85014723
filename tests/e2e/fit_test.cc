// The main job on captures that the project makes itself.
#include <gmock/gmock.h>
#include <signal.h>

#include <filesystem>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "client/io/geometry_file.h"
#include "tests/e2e/program.h"

namespace cagefit::testing {
namespace {

using ::testing::HasSubstr;

constexpr char kPng[] = "\x89PNG\r\n\x1a\n";

std::string Synth(const std::string& shape, int frames, int points,
                  const std::vector<std::string>& more = {}) {
  const std::string folder = EmptyFolder("capture_" + shape);
  std::vector<std::string> arguments = {"synth",    shape,
                                        "--out",    folder,
                                        "--frames", std::to_string(frames),
                                        "--points", std::to_string(points)};
  arguments.insert(arguments.end(), more.begin(), more.end());
  const ProgramResult result = RunCagefit(arguments);
  EXPECT_EQ(result.exit_code, 0) << result.err;
  return folder;
}

ProgramResult Fit(const std::string& input, const std::string& out,
                  const std::vector<std::string>& more) {
  std::vector<std::string> arguments = {"fit", input, "--out", out};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return RunCagefit(arguments);
}

TEST(FitEndToEndTest, ATubeThroughAServerOfItsOwnProcess) {
  const std::string capture = Synth("tube", 8, 30'000);
  ServerProgram server;
  const std::string out = EmptyFolder("fit_tube");
  const ProgramResult fit = Fit(capture, out, {"--vertices", "600", "--server", server.address()});
  ASSERT_EQ(fit.exit_code, 0) << fit.err;
  EXPECT_THAT(fit.out, HasSubstr("8 of 8 frames fitted"));
  const auto report = ReadJson(out + "/report.json");
  EXPECT_LT(report["total"]["worst_rms_percent"], 0.1);
  for (int k = 0; k < 8; ++k) {
    const auto cage = client::ReadControlMesh(out + "/frames/000" + std::to_string(k) + ".obj");
    ASSERT_TRUE(cage.ok()) << cage.status();
    EXPECT_EQ(cage->topology().BoundaryLoops().size(), 2u);
  }
  EXPECT_EQ(ReadText(out + "/cage.obj"), ReadText(out + "/frames/0007.obj"));
  EXPECT_LT(server.program().PeakMiB(), 500);
}

TEST(FitEndToEndTest, TheServerInsideGivesTheSameBits) {
  const std::string capture = Synth("blob", 3, 10'000);
  const std::string cage = capture + "_cage.obj";
  ASSERT_EQ(
      RunCagefit({"template", capture + "/frame_0000.drc", "--vertices", "200", "--out", cage})
          .exit_code,
      0);
  ServerProgram server({"--threads", "1"});
  const std::string inside = EmptyFolder("fit_inside"), outside = EmptyFolder("fit_outside");
  ASSERT_EQ(Fit(capture, inside, {"--template", cage}).exit_code, 0);
  ASSERT_EQ(Fit(capture, outside, {"--template", cage, "--server", server.address()}).exit_code, 0);
  for (const char* frame : {"/frames/0000.obj", "/frames/0001.obj", "/frames/0002.obj"}) {
    EXPECT_EQ(ReadText(inside + frame), ReadText(outside + frame)) << frame;
  }
}

TEST(FitEndToEndTest, AFileNameNeedNotBeUtf8) {
  const std::string capture = Synth("blob", 1, 3'000), out = EmptyFolder("fit_named");
  const std::string folder = EmptyFolder("named") + "/", file = folder + "fr\xe9me.drc";
  std::filesystem::copy_file(capture + "/frame_0000.drc", file);
  const ProgramResult fit = Fit(file, out, {"--vertices", "100", "--json", "--report"});
  ASSERT_EQ(fit.exit_code, 0) << fit.err;
  EXPECT_THAT(ReadJson(out + "/report.json")["frames"][0]["file"].get<std::string>(),
              HasSubstr("fr\uFFFDme.drc"));
  std::string name;  // cut between characters, not in one
  for (int k = 0; k < 150; ++k) name += "\u00e9";
  EXPECT_EQ(Fit(file, out, {"--vertices", "100", "--name", "a" + name}).exit_code, 0);
}

TEST(FitEndToEndTest, ALiveRigMayLetFramesBeSkipped) {
  const std::string capture = Synth("blob", 24, 2'000);
  const std::string cage = capture + "_cage.obj";
  ASSERT_EQ(
      RunCagefit({"template", capture + "/frame_0000.drc", "--vertices", "2000", "--out", cage})
          .exit_code,
      0);
  const std::string out = EmptyFolder("fit_latest");
  const ProgramResult fit = Fit(capture, out, {"--template", cage, "--latest", "--quick"});
  EXPECT_EQ(fit.exit_code, 4) << fit.err;
  const auto report = ReadJson(out + "/report.json");
  const int skipped = report["total"]["skipped"], fitted = report["total"]["fitted"];
  EXPECT_GT(skipped, 0) << "files come faster than 2,000 vertices are fitted";
  EXPECT_GE(fitted, 2);
  EXPECT_EQ(fitted + skipped, 24);
  EXPECT_EQ(report["session"]["skipped_frames"], std::to_string(skipped));
  EXPECT_EQ(report["frames"][23]["outcome"], "OUTCOME_FITTED") << "the last one always is";
  EXPECT_EQ(ReadText(out + "/cage.obj"), ReadText(out + "/frames/0023.obj"));
}

// Few, noisy points; eight cameras, calibrated 2 pixels off, take masks of every third frame. What
// the points leave open at the rims is known by masks, or by where the points end.
TEST(FitEndToEndTest, MasksAndBoundariesKeepATubeFromDrifting) {
  const std::string capture =
      Synth("tube", 13, 5'000,
            {"--noise", "0.003", "--cameras", "8", "--masks-every", "3", "--camera-error", "2"});
  const auto drift_of = [&](const std::vector<std::string>& more) -> double {
    const std::string out = EmptyFolder("fit_masks");
    std::vector<std::string> arguments = {"--vertices", "600", "--truth", capture + "/truth"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const ProgramResult fit = Fit(capture, out, arguments);
    EXPECT_EQ(fit.exit_code, 0) << fit.err;
    return ReadJson(out + "/report.json")["total"]["drift"]["mean_percent"];
  };
  const std::vector<std::string> masks = {"--cameras", capture + "/cameras.json", "--masks",
                                          capture + "/masks"};
  std::vector<std::string> masks_alone = masks;
  masks_alone.insert(masks_alone.end(), {"--boundary-weight", "0"});
  const double by_points = drift_of({"--boundary-weight", "0"});
  EXPECT_LT(drift_of(masks_alone), 0.9 * by_points);
  EXPECT_LT(drift_of({}), 0.8 * by_points);
  EXPECT_LT(drift_of(masks), 0.8 * by_points);
}

TEST(FitEndToEndTest, LandmarksAreReadFromAFile) {
  const std::string capture = Synth("blob", 2, 5'000), out = EmptyFolder("fit_landmarks");
  const auto fit = [&](const std::vector<std::string>& more) {
    std::vector<std::string> arguments = {"--vertices", "200"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return Fit(capture, out, arguments);
  };
  const auto vertex = [&] {
    return client::ReadControlMesh(out + "/frames/0001.obj")->vertices().col(5).eval();
  };
  ASSERT_EQ(fit({}).exit_code, 0);
  const Eigen::Vector3d wanted = vertex() + Eigen::Vector3d(0.02, 0, 0);
  const std::string file = capture + "_landmarks.txt";
  WriteText(file, absl::StrCat("# control vertex 5\nframe_0001 vertex 5 ", wanted[0], " ",
                               wanted[1], " ", wanted[2], "\n"));
  ASSERT_EQ(fit({"--landmarks", file}).exit_code, 0);
  EXPECT_LT((vertex() - wanted).norm(), 0.01);
  const auto report = ReadJson(out + "/report.json");
  EXPECT_EQ(report["frames"][0]["final_energies"]["landmarks"], 0);
  EXPECT_GT(report["frames"][1]["final_energies"]["landmarks"], 0);

  WriteText(file, "frame_0002 vertex 5 0 0 0\n");
  const ProgramResult refused = fit({"--landmarks", file});
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_THAT(refused.err, HasSubstr("_landmarks.txt: line 1: the frame is \"frame_0002\""));
}

TEST(FitEndToEndTest, ABlobKeepsItsMaterialPoints) {
  const std::string capture = Synth("blob", 8, 20'000), out = EmptyFolder("fit_blob");
  ASSERT_EQ(Fit(capture, out, {"--vertices", "400"}).exit_code, 0);
  EXPECT_LT(ReadJson(out + "/report.json")["total"]["worst_rms_percent"], 0.05);
  const ProgramResult evaluated =
      RunCagefit({"evaluate", out + "/frames", capture, "--truth", capture + "/truth", "--json"});
  ASSERT_EQ(evaluated.exit_code, 0) << evaluated.err;
  const auto frames = nlohmann::json::parse(evaluated.out);
  EXPECT_LT(frames[7]["drift"]["mean_percent"], 2.5);
}

TEST(FitEndToEndTest, DriftIsMeasuredAgainstTheTrueMotion) {
  const std::string capture = Synth("blob", 4, 10'000), out = EmptyFolder("fit_truth");
  const ProgramResult fit =
      Fit(capture, out, {"--vertices", "200", "--quick", "--truth", capture + "/truth"});
  ASSERT_EQ(fit.exit_code, 0) << fit.err;
  EXPECT_THAT(fit.out, HasSubstr("Drift against the true motion since frame 0"));
  const auto report = ReadJson(out + "/report.json");
  EXPECT_EQ(report["total"]["drift"]["measured"], "against_true_motion");
  EXPECT_GT(report["total"]["drift"]["mean_percent"], 0);
  EXPECT_LT(report["total"]["drift"]["mean_percent"], 2);
  const ProgramResult evaluated =
      RunCagefit({"evaluate", out + "/frames", capture, "--truth", capture + "/truth", "--json"});
  ASSERT_EQ(evaluated.exit_code, 0) << evaluated.err;
  const double mean = report["frames"][3]["drift"]["mean"];
  EXPECT_NEAR(nlohmann::json::parse(evaluated.out)[3]["drift"]["mean"], mean, 1e-4 * mean)
      << "of the same control meshes, but for the digits of .obj files";
}

TEST(FitEndToEndTest, WithoutATrueMotionTheRoundTripTellsDrift) {
  const std::string capture = Synth("blob", 4, 10'000), out = EmptyFolder("fit_round_trip");
  const ProgramResult fit = Fit(capture, out, {"--vertices", "200", "--quick", "--round-trip"});
  ASSERT_EQ(fit.exit_code, 0) << fit.err;
  EXPECT_THAT(fit.out, HasSubstr("Round-trip drift"));
  const auto report = ReadJson(out + "/report.json");
  EXPECT_EQ(report["total"]["drift"]["measured"], "round_trip");
  EXPECT_GT(report["total"]["drift"]["mean_percent"], 0);
  EXPECT_LT(report["total"]["drift"]["mean_percent"], 2);
  EXPECT_EQ(report["frames"].size(), 4u);
  ASSERT_EQ(report["way_back"].size(), 3u);
  EXPECT_EQ(report["way_back"][2]["file"], report["frames"][0]["file"]);
  EXPECT_EQ(report["way_back"][2]["sequence_number"], "6");
  EXPECT_EQ(ReadText(out + "/cage.obj"), ReadText(out + "/frames/0003.obj"))
      << "the way back leaves the result alone";
}

TEST(FitEndToEndTest, ATrueMotionThatDoesNotMatchIsWrongUsage) {
  const std::string capture = Synth("blob", 3, 1'000), out = EmptyFolder("fit_wrong_truth");
  const std::string truth = capture + "/truth/frame_0000.ply";
  const std::string other_mesh = EmptyFolder("other_truth") + "/other.ply";
  const auto fit = [&](const std::vector<std::string>& flags) {
    std::vector<std::string> more = {"--vertices", "100"};
    more.insert(more.end(), flags.begin(), flags.end());
    return Fit(capture, out, more);
  };
  const ProgramResult few = fit({"--truth", truth, truth});
  EXPECT_EQ(few.exit_code, 2);
  EXPECT_THAT(few.err, HasSubstr("2 frames of the true motion; expected"));
  ASSERT_EQ(RunCagefit({"template", truth, "--vertices", "50", "--out", other_mesh}).exit_code, 0);
  const ProgramResult other = fit({"--truth", truth, other_mesh, truth});
  EXPECT_EQ(other.exit_code, 2);
  EXPECT_THAT(other.err, HasSubstr("/other.ply: 50 vertices and 96 triangles"));
  EXPECT_EQ(fit({"--truth", truth, "--round-trip"}).exit_code, 2);
  EXPECT_EQ(Fit(truth, out, {"--vertices", "100", "--round-trip"}).exit_code, 2);
}

TEST(FitEndToEndTest, NoiseAndOutliersDoNotThrowItOff) {
  const std::string capture =
      Synth("blob", 3, 20'000, {"--noise", "0.002", "--outliers", "0.01", "--seed", "3"});
  const std::string out = EmptyFolder("fit_noise");
  ASSERT_EQ(Fit(capture, out, {"--vertices", "300"}).exit_code, 0);
  const ProgramResult evaluated =
      RunCagefit({"evaluate", out + "/cage.obj", capture + "/truth/frame_0002.ply", "--json"});
  const auto frames = nlohmann::json::parse(evaluated.out);
  EXPECT_LT(frames[0]["distances"]["target_to_fit"]["rms_percent"], 0.2);
}

TEST(FitEndToEndTest, FilesOfOtherFormatsAndAMeshWork) {
  const std::string capture = Synth("tube", 2, 10'000, {"--format", "ply"});
  const std::string out = EmptyFolder("fit_ply");
  const ProgramResult clouds = Fit(capture, out, {"--vertices", "300"});
  ASSERT_EQ(clouds.exit_code, 0) << clouds.err;
  const std::string mesh_out = EmptyFolder("fit_mesh");
  const ProgramResult mesh =
      Fit(capture + "/truth/frame_0000.ply", mesh_out, {"--vertices", "300"});
  ASSERT_EQ(mesh.exit_code, 0) << mesh.err;
  EXPECT_LT(ReadJson(mesh_out + "/report.json")["total"]["worst_rms_percent"], 0.1);
}

TEST(FitEndToEndTest, AToleranceIsMetWithAsManyVerticesAsItTakes) {
  const std::string capture = Synth("blob", 3, 20'000);
  const std::string out = EmptyFolder("fit_tolerance");
  const ProgramResult fit = Fit(capture, out, {"--tolerance", "0.2%"});
  ASSERT_EQ(fit.exit_code, 0) << fit.err << fit.out;
  EXPECT_THAT(fit.out, HasSubstr("Within tolerance: "));
  const auto report = ReadJson(out + "/report.json");
  const auto& tolerance = report["frames"][0]["tolerance"];
  EXPECT_EQ(tolerance["end"], "TOLERANCE_END_WITHIN");
  EXPECT_LE(tolerance["most_percent"], 0.2);
  EXPECT_FALSE(report["frames"][1].contains("tolerance"));
  for (const char* frame : {"/frames/0000.obj", "/frames/0002.obj"}) {
    const auto cage = client::ReadControlMesh(out + frame);
    ASSERT_TRUE(cage.ok()) << cage.status();
    EXPECT_EQ(cage->vertex_count(), tolerance["control_vertices"]);
  }
}

TEST(FitEndToEndTest, AToleranceRefinesATemplateThatIsGiven) {
  const std::string capture = Synth("blob", 2, 20'000);
  const std::string out = EmptyFolder("fit_refined"), cage = capture + "_small.obj";
  ASSERT_EQ(RunCagefit({"template", capture + "/frame_0000.drc", "--vertices", "60", "--out", cage})
                .exit_code,
            0);
  const ProgramResult fit = Fit(capture, out, {"--template", cage, "--tolerance", "0.05%"});
  ASSERT_EQ(fit.exit_code, 0) << fit.err << fit.out;
  const auto refined = client::ReadControlMesh(out + "/cage.obj");
  ASSERT_TRUE(refined.ok()) << refined.status();
  EXPECT_GT(refined->vertex_count(), client::ReadControlMesh(cage)->vertex_count());
}

TEST(FitEndToEndTest, AToleranceThatIsNotMetIsReportedAsSuch) {
  const std::string capture = Synth("blob", 1, 10'000), out = EmptyFolder("fit_not_met");
  const ProgramResult fit =
      Fit(capture, out, {"--vertices", "60", "--tolerance", "0.01%", "--max-vertices", "80"});
  EXPECT_EQ(fit.exit_code, 4) << fit.err;
  EXPECT_THAT(fit.out, HasSubstr("NOT within tolerance, the limit of control vertices is reached"));
  EXPECT_EQ(client::ReadControlMesh(out + "/cage.obj")->vertex_count(), 80);
}

TEST(FitEndToEndTest, ABadFrameIsRefusedAndTheRestGoesOn) {
  const std::string capture = Synth("blob", 4, 5'000), out = EmptyFolder("fit_bad");
  WriteText(capture + "/frame_0002.drc", kPng);
  const ProgramResult fit = Fit(capture, out, {"--vertices", "100", "--quick"});
  EXPECT_EQ(fit.exit_code, 4);
  EXPECT_THAT(fit.err, HasSubstr("frame_0002.drc was refused"));
  const auto report = ReadJson(out + "/report.json");
  EXPECT_EQ(report["total"]["fitted"], 3);
  EXPECT_EQ(report["total"]["refused"], 1);
  EXPECT_EQ(report["frames"][2]["error"]["code"], "INVALID_ARGUMENT");
  EXPECT_FALSE(std::filesystem::exists(out + "/frames/0002.obj"));
  EXPECT_TRUE(std::filesystem::exists(out + "/frames/0003.obj"));
}

TEST(FitEndToEndTest, AnUnreadableFileIsRefusedToo) {
  const std::string capture = Synth("blob", 3, 5'000, {"--format", "ply"});
  WriteText(capture + "/frame_0000.ply", "ply\nnonsense\n");
  const std::string out = EmptyFolder("fit_unreadable");
  const ProgramResult fit = Fit(capture, out, {"--vertices", "100", "--quick", "--json"});
  EXPECT_EQ(fit.exit_code, 4);
  const auto report = ReadJson(out + "/report.json");
  EXPECT_THAT(std::string(report["frames"][0]["error"]["message"]), HasSubstr("line 2"));
  EXPECT_EQ(report["total"]["fitted"], 2);
}

TEST(FitEndToEndTest, SessionsThatAreKeptCanBeListedPulledAndDeleted) {
  const std::string capture = Synth("blob", 2, 5'000), out = EmptyFolder("fit_kept");
  ServerProgram server;
  ASSERT_EQ(Fit(capture, out,
                {"--vertices", "100", "--quick", "--keep-session", "--name", "kept", "--server",
                 server.address()})
                .exit_code,
            0);
  const auto session = [&](std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), "session");
    arguments.insert(arguments.end(), {"--server", server.address()});
    return RunCagefit(arguments);
  };
  const auto sessions = nlohmann::json::parse(session({"list", "--json"}).out);
  ASSERT_EQ(sessions.size(), 1u);
  EXPECT_EQ(sessions[0]["name"], "kept");
  const std::string id = sessions[0]["session_id"];
  EXPECT_THAT(session({"show", id}).out, HasSubstr(id));
  ASSERT_EQ(session({"pull", id, "--frame", "0", "--out", out + "/pulled.obj"}).exit_code, 0);
  EXPECT_EQ(ReadText(out + "/pulled.obj"), ReadText(out + "/frames/0000.obj"));
  ASSERT_EQ(session({"pull", id, "--surface", "--out", out + "/surface.ply"}).exit_code, 0);
  EXPECT_TRUE(client::ReadGeometry(out + "/surface.ply").ok());
  EXPECT_EQ(session({"delete", id}).exit_code, 0);
  const ProgramResult gone = session({"show", id});
  EXPECT_EQ(gone.exit_code, 1);
  EXPECT_THAT(gone.err, HasSubstr(id));
}

TEST(FitEndToEndTest, AServerThatIsToldToEndDrainsAndEndsWithZero) {
  // Several times: a signal that meets the wrong thread ends the process without a word.
  for (const int signal : {SIGTERM, SIGINT, SIGTERM, SIGINT, SIGTERM}) {
    ServerProgram server;
    server.program().Signal(signal);
    EXPECT_EQ(server.program().Wait(), 0);
  }
}

TEST(FitEndToEndTest, AFolderThatTakesNoMoreFilesEndsTheFit) {
  const std::string capture = Synth("blob", 20, 5'000), out = EmptyFolder("fit_full");
  // A folder stands where the second control mesh has to go.
  std::filesystem::create_directories(out + "/frames/0001.obj");
  const ProgramResult fit = Fit(capture, out, {"--vertices", "100", "--quick"});
  EXPECT_EQ(fit.exit_code, 4);
  EXPECT_THAT(fit.err, HasSubstr("/frames/0001.obj: cannot be written"));
}

TEST(FitEndToEndTest, CtrlCLeavesWhatWasFitted) {
  const std::string capture = Synth("blob", 40, 40'000), out = EmptyFolder("fit_interrupted");
  const std::string cage = capture + "/truth/frame_0000.ply";
  RunningProgram fit(CagefitProgram(),
                     {"fit", capture, "--template", cage, "--out", out, "--json"});
  ASSERT_THAT(fit.ReadLine(), HasSubstr("\"frame\":0"));
  fit.Signal(SIGINT);
  EXPECT_EQ(fit.Wait(), 4);
  const auto report = ReadJson(out + "/report.json");
  EXPECT_GE(report["total"]["fitted"], 1);
  EXPECT_LT(report["total"]["fitted"], 40);
  EXPECT_GT(report["total"]["unanswered"], 0);
  EXPECT_TRUE(std::filesystem::exists(out + "/frames/0000.obj"));
}

}  // namespace
}  // namespace cagefit::testing
