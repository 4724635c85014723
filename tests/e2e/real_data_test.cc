// The main job on real models, scans and sequences.
#include <gmock/gmock.h>

#include "client/io/geometry_file.h"
#include "tests/e2e/program.h"
#include "tests/support/data.h"

namespace cagefit::testing {
namespace {

double EvaluatedRmsPercent(const std::string& cage, const std::string& target) {
  const ProgramResult evaluated = RunCagefit({"evaluate", cage, target, "--json"});
  EXPECT_EQ(evaluated.exit_code, 0) << evaluated.err;
  return nlohmann::json::parse(evaluated.out)[0]["distances"]["target_to_fit"]["rms_percent"];
}

struct Static {
  const char* target;
  int vertices;
  int loops;  // -1: as it comes
  double most_rms_percent;
};

void PrintTo(const Static& c, std::ostream* out) { *out << c.target << ", " << c.vertices; }

class StaticFitTest : public ::testing::TestWithParam<Static> {};

TEST_P(StaticFitTest, ComesClose) {
  CAGEFIT_NEEDS_DATA();
  const Static& c = GetParam();
  const std::string target = DataDir() + "/" + c.target, out = EmptyFolder("static_fit");
  const ProgramResult fit = RunCagefit(
      {"fit", target, "--vertices", std::to_string(c.vertices), "--out", out, "--quick"});
  ASSERT_EQ(fit.exit_code, 0) << fit.err;
  const auto cage = client::ReadControlMesh(out + "/cage.obj");
  ASSERT_TRUE(cage.ok()) << cage.status();
  EXPECT_NEAR(cage->vertex_count(), c.vertices, 0.01 * c.vertices);
  if (c.loops >= 0) {
    EXPECT_EQ(static_cast<int>(cage->topology().BoundaryLoops().size()), c.loops);
  }
  EXPECT_LT(EvaluatedRmsPercent(out + "/cage.obj", target), c.most_rms_percent);
}

INSTANTIATE_TEST_SUITE_P(RealData, StaticFitTest,
                         ::testing::Values(Static{"static/bunny_35947.ply", 314, 5, 0.2},
                                           Static{"static/bunny_35947.ply", 4667, 5, 0.035},
                                           Static{"static/bunny_closed_34835.ply", 314, 0, 0.2},
                                           Static{"static/bunny_closed_34835.ply", 4667, 0, 0.035},
                                           Static{"static/face_25905.ply", 1000, 1, 0.05},
                                           Static{"scans/bunny_72027_resampled.ply", 2000, 0, 0.1},
                                           // Ten noisy views, with holes where none of them looked.
                                           Static{"scans/bunny_raw_362272.ply", 1000, -1, 0.3}),
                         [](const ::testing::TestParamInfo<Static>& info) {
                           std::string name = std::string(info.param.target) + "_" +
                                              std::to_string(info.param.vertices);
                           for (char& c : name) c = isalnum(c) ? c : '_';
                           return name;
                         });

struct Tolerance {
  const char* target;
  const char* tolerance;
  double percent;
  int most_vertices;
};

// Tolerances that a fit reaches with a coarse mesh, and what it takes.
TEST(ToleranceFitTest, RealModelsAreMetWithFewVertices) {
  CAGEFIT_NEEDS_DATA();
  for (const Tolerance& c : {Tolerance{"static/bunny_closed_34835.ply", "0.2%", 0.2, 2500},
                             Tolerance{"static/spot_11533.ply", "0.2%", 0.2, 600},
                             Tolerance{"static/fandisk_6475.ply", "0.5%", 0.5, 800}}) {
    SCOPED_TRACE(c.target);
    const std::string out = EmptyFolder("tolerance");
    const ProgramResult fit = RunCagefit(
        {"fit", DataDir() + "/" + c.target, "--tolerance", c.tolerance, "--out", out, "--quick"});
    ASSERT_EQ(fit.exit_code, 0) << fit.err << fit.out;
    const auto tolerance = ReadJson(out + "/report.json")["frames"][0]["tolerance"];
    EXPECT_EQ(tolerance["end"], "TOLERANCE_END_WITHIN");
    EXPECT_LE(tolerance["most_percent"], c.percent);
    const auto cage = client::ReadControlMesh(out + "/cage.obj");
    ASSERT_TRUE(cage.ok()) << cage.status();
    EXPECT_EQ(cage->vertex_count(), tolerance["control_vertices"]);
    EXPECT_LE(cage->vertex_count(), c.most_vertices);
  }
}

TEST(SequenceFitTest, TheTShirtStaysBelowAFifthOfAPercentInEveryFrame) {
  CAGEFIT_NEEDS_DATA();
  ServerProgram server;
  const std::string out = EmptyFolder("tshirt");
  const ProgramResult fit = RunCagefit({"fit", DataDir() + "/tshirt/drc", "--vertices", "2046",
                                        "--out", out, "--server", server.address()});
  ASSERT_EQ(fit.exit_code, 0) << fit.err;
  const auto report = ReadJson(out + "/report.json");
  EXPECT_EQ(report["total"]["fitted"], 30);
  for (const auto& frame : report["frames"]) {
    EXPECT_LT(frame["distances"]["rms_percent"], 0.2) << frame["file"];
  }
  const auto cage = client::ReadControlMesh(out + "/cage.obj");
  ASSERT_TRUE(cage.ok()) << cage.status();
  EXPECT_EQ(cage->vertex_count(), 2046);
  EXPECT_EQ(cage->topology().BoundaryLoops().size(), 4u);  // neck, hem, two sleeves
  EXPECT_LT(server.program().PeakMiB(), 500);
}

TEST(SequenceFitTest, ThePuppetStaysClose) {
  CAGEFIT_NEEDS_DATA();
  const std::string out = EmptyFolder("puppet");
  const ProgramResult fit =
      RunCagefit({"fit", DataDir() + "/puppet/drc", "--vertices", "1252", "--out", out, "--quick"});
  ASSERT_EQ(fit.exit_code, 0) << fit.err;
  const auto report = ReadJson(out + "/report.json");
  EXPECT_EQ(report["total"]["fitted"], 30);
  EXPECT_LT(report["total"]["worst_rms_percent"], 0.1);
}

TEST(SequenceFitTest, ACloudWithoutNormalsIsFittedFrameAfterFrame) {
  CAGEFIT_NEEDS_DATA();
  const std::string out = EmptyFolder("lucky_cat");
  const ProgramResult fit = RunCagefit(
      {"fit", DataDir() + "/sequences/bv_points16", "--vertices", "500", "--out", out, "--quick"});
  const auto report = ReadJson(out + "/report.json");
  EXPECT_EQ(report["total"]["fitted"], 16) << fit.err;
}

}  // namespace
}  // namespace cagefit::testing
