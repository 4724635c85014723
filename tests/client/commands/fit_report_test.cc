#include "client/commands/fit_report.h"

#include <gmock/gmock.h>

#include <sstream>

namespace cagefit::client {
namespace {

using ::testing::HasSubstr;

FitReport ThreeFrames() {
  FitReport report;
  report.diagonal = 2;
  report.frames.resize(3);
  for (FrameRecord& frame : report.frames) frame.file = "f.drc";
  report.frames[0].status = absl::OkStatus();
  report.frames[0].distances = DistanceStats{0.001, 0.002, 0.004, 100};
  report.frames[0].reply.set_verdict(v1::VERDICT_OK);
  report.frames[1].status = absl::InvalidArgumentError("not Draco");
  report.frames[2].status = absl::OkStatus();
  report.frames[2].reply.mutable_distances()->set_rms_percent(0.3);
  report.frames[2].reply.set_verdict(v1::VERDICT_LOST);
  return report;
}

TEST(FitReportTest, TotalsTakeExactDistancesWhereThereAre) {
  const FitTotals totals = Totals(ThreeFrames());
  EXPECT_EQ(totals.fitted, 2);
  EXPECT_EQ(totals.refused, 1);
  EXPECT_EQ(totals.lost, 1);
  EXPECT_NEAR(totals.worst_rms_percent, 0.3, 1e-12);
  EXPECT_NEAR(totals.mean_rms_percent, (0.1 + 0.3) / 2, 1e-12);
}

TEST(FitReportTest, FramesThatWereNeverAnsweredAreNotRefused) {
  FitReport report = ThreeFrames();
  report.frames.emplace_back();
  EXPECT_EQ(Totals(report).refused, 1);
  EXPECT_EQ(Totals(report).unanswered, 1);
}

TEST(FitReportTest, SkippedFramesAreNotRefused) {
  FitReport report = ThreeFrames();
  report.frames[1].reply.set_outcome(v1::OUTCOME_SKIPPED);
  EXPECT_EQ(Totals(report).refused, 0);
  EXPECT_EQ(Totals(report).skipped, 1);
  EXPECT_EQ(ReportJson(report)["total"]["skipped"], 1);
  std::ostringstream table;
  PrintFitTable(report, table);
  EXPECT_THAT(table.str(), HasSubstr("2 of 3 frames fitted, 1 skipped, 0 refused"));
}

TEST(FitReportTest, JsonHoldsEveryFrame) {
  const Json json = ReportJson(ThreeFrames());
  ASSERT_EQ(json["frames"].size(), 3u);
  EXPECT_NEAR(json["frames"][0]["distances"]["rms_percent"], 0.1, 1e-12);
  EXPECT_EQ(json["frames"][1]["error"]["message"], "not Draco");
  EXPECT_EQ(json["frames"][2]["verdict"], "VERDICT_LOST");
  EXPECT_EQ(json["total"]["fitted"], 2);
}

TEST(FitReportTest, NoiseOutliersAndCoverageAreTold) {
  FitReport report = ThreeFrames();
  report.frames[0].reply.set_noise(0.005);
  report.frames[0].reply.set_outliers(1234);
  report.frames[0].reply.mutable_final_energies()->set_coverage(0.5);
  const Json json = ReportJson(report);
  EXPECT_EQ(json["frames"][0]["noise"], 0.005);
  EXPECT_EQ(json["frames"][0]["outliers"], "1234") << "proto3 JSON writes 64 bits as text";
  EXPECT_EQ(json["frames"][0]["final_energies"]["coverage"], 0.5);
  std::ostringstream table;
  PrintFitTable(report, table);
  EXPECT_THAT(table.str(), HasSubstr("0.2500     1234")) << "noise in percent, and outliers";
}

TEST(FitReportTest, WhatToleranceModeCameToIsTold) {
  FitReport report = ThreeFrames();
  EXPECT_FALSE(Totals(report).beyond_tolerance);
  v1::ToleranceReport* tolerance = report.frames[0].reply.mutable_tolerance();
  tolerance->set_control_vertices(1234);
  tolerance->set_rounds(7);
  tolerance->set_most_percent(0.0875);
  for (const auto& [end, words] :
       {std::pair(v1::TOLERANCE_END_WITHIN, "Within tolerance: 1234 control vertices after 7"),
        std::pair(v1::TOLERANCE_END_VERTEX_LIMIT, "NOT within tolerance, the limit"),
        std::pair(v1::TOLERANCE_END_NO_FURTHER, "NOT within tolerance, more control vertices")}) {
    tolerance->set_end(end);
    std::ostringstream table;
    PrintFitTable(report, table);
    EXPECT_THAT(table.str(), HasSubstr(words));
    EXPECT_THAT(table.str(), HasSubstr("0.0875 %"));
    EXPECT_EQ(Totals(report).beyond_tolerance, end != v1::TOLERANCE_END_WITHIN);
    EXPECT_EQ(ReportJson(report)["frames"][0]["tolerance"]["control_vertices"], 1234);
  }
}

TEST(FitReportTest, TheTableShowsTheWorstOfManyFrames) {
  FitReport report = ThreeFrames();
  report.frames.resize(200, report.frames[0]);
  std::ostringstream table;
  PrintFitTable(report, table);
  EXPECT_THAT(table.str(), HasSubstr("The 60 worst of 200 frames"));
  EXPECT_THAT(table.str(), HasSubstr("not Draco"));
  EXPECT_THAT(table.str(), HasSubstr("LOST"));
  EXPECT_THAT(table.str(), HasSubstr("199 of 200 frames fitted"));
}

}  // namespace
}  // namespace cagefit::client
