// The main job on real models, scans and sequences.
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>

#include "client/io/geometry_file.h"
#include "tests/e2e/program.h"
#include "tests/support/data.h"

namespace cagefit::testing {
namespace {

struct Distances {
  double rms_percent, max_percent;
};

// Of a closed model both ways; from the target alone where parts of it are missing.
Distances Evaluate(const std::string& cage, const std::string& target, bool both_ways) {
  const ProgramResult evaluated = RunCagefit({"evaluate", cage, target, "--json"});
  EXPECT_EQ(evaluated.exit_code, 0) << evaluated.err;
  const auto distances = nlohmann::json::parse(evaluated.out)[0]["distances"];
  const auto& to_fit = distances["target_to_fit"];
  if (!both_ways) return {to_fit["rms_percent"], to_fit["max_percent"]};
  const auto& to_target = distances["fit_to_target"];
  const double a = to_fit["rms_percent"], b = to_target["rms_percent"];
  const double to_fit_max = to_fit["max_percent"], to_target_max = to_target["max_percent"];
  return {std::sqrt((a * a + b * b) / 2), std::max(to_fit_max, to_target_max)};
}

struct Static {
  const char* target;
  int vertices;
  int loops;  // -1: as it comes
  bool is_closed;
  double most_rms_percent;
  double most_percent = 100;  // Hausdorff distance
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
  const Distances distances = Evaluate(out + "/cage.obj", target, c.is_closed);
  EXPECT_LT(distances.rms_percent, c.most_rms_percent);
  EXPECT_LT(distances.max_percent, c.most_percent);
}

INSTANTIATE_TEST_SUITE_P(
    RealData, StaticFitTest,
    ::testing::Values(Static{"static/bunny_closed_34835.ply", 314, 0, true, 0.13},
                      Static{"static/bunny_closed_34835.ply", 4667, 0, true, 0.02, 0.3},
                      Static{"static/spot_11533.ply", 800, 0, true, 0.04, 0.4},
                      Static{"static/armadillo_49990.ply", 8000, 0, true, 0.03, 0.25},
                      Static{"static/fandisk_6475.ply", 600, 0, true, 0.02},
                      Static{"static/bunny_35947.ply", 314, 5, false, 0.13},
                      Static{"static/bunny_35947.ply", 4667, 5, false, 0.02},
                      Static{"static/face_25905.ply", 1000, 1, false, 0.03},
                      Static{"scans/bunny_72027_resampled.ply", 2000, 0, false, 0.06},
                      // Ten noisy views, with holes where none of them looked.
                      Static{"scans/bunny_raw_362272.ply", 1000, -1, false, 0.3},
                      // Scraps beside the lion are left out of its template.
                      Static{"scans/lion_takanawa_341989.ply", 2000, -1, false, 1.6}),
    [](const ::testing::TestParamInfo<Static>& info) {
      std::string name = std::string(info.param.target) + "_" + std::to_string(info.param.vertices);
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
