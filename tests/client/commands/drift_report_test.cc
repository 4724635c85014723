#include "client/commands/drift_report.h"

#include <gmock/gmock.h>

#include <filesystem>
#include <sstream>

#include "client/io/geometry_file.h"
#include "core/subdiv/limit.h"
#include "tests/support/shapes.h"
#include "tests/support/temp_folder.h"

namespace cagefit::client {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

ControlMesh Cage() {
  TriangleMesh mesh = testing::Icosphere(1);
  return ControlMesh::Create(std::move(mesh.vertices), std::move(mesh.triangles)).value();
}

// Frame k of the fit lies k shifts along x.
FitReport Shifted(int frames, double shift) {
  FitReport report;
  report.diagonal = 4;
  report.frames.resize(frames);
  for (int k = 0; k < frames; ++k) {
    report.frames[k].status = absl::OkStatus();
    report.frames[k].control_vertices =
        Cage().vertices().colwise() + k * shift * Eigen::Vector3d::UnitX();
  }
  return report;
}

std::string Table(const FitReport& report) {
  std::ostringstream out;
  PrintFitTable(report, out);
  return out.str();
}

TEST(DriftReportTest, AgainstTheTrueMotionEveryFrameAndTheTotalAreTold) {
  const std::string folder = cagefit::testing::TempFolder() + "drift_report_truth";
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
  for (int k = 0; k < 3; ++k) {  // the true motion is half as fast
    TriangleMesh mesh = testing::Icosphere(2);
    mesh.vertices.row(0).array() += 0.1 * k;
    ASSERT_TRUE(WriteMesh(folder + "/f" + std::to_string(k) + ".ply", mesh).ok());
  }
  FitReport report = Shifted(3, 0.2);
  report.drift_kind = DriftKind::kTruth;
  auto truth = TrueMotion::Open({folder}, 3);
  ASSERT_TRUE(truth.ok()) << truth.status();
  ASSERT_TRUE(MeasureTrueDrift(Cage(), &*truth, &report).ok());
  EXPECT_NEAR(report.frames[0].drift->max, 0, 1e-6);
  EXPECT_NEAR(report.frames[1].drift->mean, 0.1, 1e-6);
  EXPECT_NEAR(report.frames[2].drift->max, 0.2, 1e-6);
  const Json json = ReportJson(report);
  EXPECT_EQ(json["total"]["drift"]["measured"], "against_true_motion");
  EXPECT_NEAR(json["total"]["drift"]["mean_percent"], 100 * 0.15 / 4, 1e-4);
  EXPECT_NEAR(json["frames"][2]["drift"]["rms_percent"], 5, 1e-4);
  EXPECT_THAT(Table(report), AllOf(HasSubstr("Drift against the true motion since frame 0"),
                                   HasSubstr("3.7500"), Not(HasSubstr("Round-trip"))));
}

TEST(DriftReportTest, TheRoundTripComparesEachFrameWithItsFitOnTheWayBack) {
  FitReport report = Shifted(3, 0.2);
  report.drift_kind = DriftKind::kRoundTrip;
  report.way_back = {report.frames[1], report.frames[0]};
  report.way_back[0].control_vertices.row(1).array() += 0.1;
  report.way_back[1].control_vertices.row(1).array() += 0.3;
  MeasureRoundTripDrift(Cage(), &report);
  EXPECT_NEAR(report.frames[0].drift->mean, 0.3, 1e-12);
  EXPECT_NEAR(report.frames[1].drift->mean, 0.1, 1e-12);
  EXPECT_FALSE(report.frames[2].drift.has_value()) << "the way back begins there";
  const Json json = ReportJson(report);
  EXPECT_EQ(json["total"]["drift"]["measured"], "round_trip");
  EXPECT_NEAR(json["total"]["drift"]["mean_percent"], 7.5, 1e-9) << "frame 0's";
  EXPECT_EQ(json["way_back"][0]["frame"], 1);
  EXPECT_THAT(Table(report), AllOf(HasSubstr("Round-trip drift (no true motion given)"),
                                   HasSubstr("There and back to frame 0"), HasSubstr("7.5000")));
}

TEST(DriftReportTest, ARoundTripThatDoesNotComeHomeMeasuresNothing) {
  FitReport report = Shifted(2, 0.2);
  report.drift_kind = DriftKind::kRoundTrip;
  report.way_back.resize(1);  // not answered
  MeasureRoundTripDrift(Cage(), &report);
  EXPECT_FALSE(TotalDrift(report).has_value());
  EXPECT_FALSE(ReportJson(report)["total"]["drift"].contains("mean"));
  EXPECT_THAT(Table(report), HasSubstr("Round-trip drift: not measured"));
}

TEST(DriftReportTest, NothingIsSaidWhereNoDriftWasAskedFor) {
  const FitReport report = Shifted(2, 0.2);
  EXPECT_FALSE(ReportJson(report)["total"].contains("drift"));
  EXPECT_THAT(Table(report), Not(HasSubstr("rift")));
}

}  // namespace
}  // namespace cagefit::client
