#include "client/report/html_report.h"

#include <gmock/gmock.h>

#include <cmath>
#include <list>
#include <optional>

#include "absl/strings/str_cat.h"
#include "client/io/file_bytes.h"
#include "client/io/geometry_file.h"
#include "client/report/page_files.h"
#include "core/subdiv/limit.h"
#include "tests/client/report/page_reader.h"
#include "tests/support/shapes.h"
#include "tests/support/temp_folder.h"

namespace cagefit::client {
namespace {

using ::cagefit::testing::PageData;
using ::cagefit::testing::ReadPayload;
using ::cagefit::testing::SplitPage;
using ::testing::Each;
using ::testing::HasSubstr;
using ::testing::Not;

int Count(const std::string& text, const std::string& what) {
  int count = 0;
  for (size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + 1)) ++count;
  return count;
}

// A drum with creases round both ends that grows, and its targets: frame 2 was refused.
class HtmlReportTest : public ::testing::Test {
 protected:
  HtmlReportTest() : folder_(cagefit::testing::TempFolder() + "html_report") {
    EXPECT_EQ(MakeFolder(folder_), absl::OkStatus());
    const TriangleMesh drum = testing::Drum(3);
    CreaseTags tags;
    for (int64_t h = 0; h < drum.triangles.size(); ++h) {
      const int32_t a = drum.triangles.data()[h];
      const int32_t b = drum.triangles.data()[h % 3 == 2 ? h - 2 : h + 1];
      if (a < b && IsOnRim(drum.vertices.col(a)) && IsOnRim(drum.vertices.col(b)) &&
          drum.vertices(2, a) == drum.vertices(2, b)) {
        tags.edges.push_back({a, b});
      }
    }
    cage_.emplace(ControlMesh::Create(drum.vertices, drum.triangles, tags).value());
  }
  static bool IsOnRim(const Eigen::Vector3d& x) { return x.head<2>().norm() > 1 - 1e-9; }

  HtmlReport Report(int count, const std::string& name = "frame") {
    HtmlReport report;
    report.cage = &*cage_;
    report.report["total"] = {{"frames", count}};
    for (int k = 0; k < count; ++k) {
      const std::string file = absl::StrCat(folder_, "/", k, ".ply");
      report.report["frames"].push_back({{"frame", k}, {"file", absl::StrCat(name, k)}});
      if (k == 2) {
        report.report["frames"].back()["error"] = {{"code", "INVALID_ARGUMENT"}, {"message", name}};
        continue;
      }
      vertices_.push_back((1 + 0.01 * k) * cage_->vertices());
      PointCloud target;
      target.points = (1.001 * vertices_.back()).cast<float>();
      EXPECT_EQ(WriteCloud(file, target), absl::OkStatus());
      report.frames.push_back({static_cast<size_t>(k), file, &vertices_.back(), 1});
    }
    return report;
  }
  std::string Written(const HtmlReport& report) {
    const std::string path = folder_ + "/report.html";
    EXPECT_EQ(WriteHtmlReport(path, report), absl::OkStatus());
    return ReadFileBytes(path, 1 << 30).value();
  }
  PageData Data(const HtmlReport& report) { return ReadPayload(SplitPage(Written(report)).data); }

  const std::string folder_;
  std::optional<ControlMesh> cage_;
  std::list<Points3d> vertices_;
};

// Points of a frame as the page finds them.
Points3d Positions(const PageData& data, const std::string& array, size_t begin, size_t count) {
  const auto& grid = data.header["scene"][array];
  Points3d points(3, count);
  for (size_t i = 0; i < 3 * count; ++i) {
    points.data()[i] = grid["origin"][i % 3].get<double>() +
                       grid["quantum"].get<double>() * data.arrays.at(array).at(3 * begin + i);
  }
  return points;
}

TEST_F(HtmlReportTest, PositionsAreWithinTheirQuantum) {
  const HtmlReport report = Report(5);
  const PageData data = Data(report);
  const double quantum = data.header["scene"]["control"]["quantum"];
  EXPECT_LT(quantum, 2.1 / 65535);
  const auto n = static_cast<size_t>(cage_->vertex_count());
  ASSERT_EQ(data.header["scene"]["frames"].size(), 4u);
  for (size_t k = 0; k < 4; ++k) {
    const Points3d positions = Positions(data, "control", k * n, n);
    EXPECT_LT((positions - *report.frames[k].control_vertices).cwiseAbs().maxCoeff(),
              0.51 * quantum);
    EXPECT_EQ(data.header["scene"]["frames"][k]["frame"], report.frames[k].number);
    EXPECT_EQ(data.header["scene"]["frames"][k]["points"], n);
  }
  const double point_quantum = data.header["scene"]["points"]["quantum"];
  const Points3d target = 1.001 * *report.frames[3].control_vertices;
  EXPECT_LT((Positions(data, "points", 3 * n, n) - target).cwiseAbs().maxCoeff(),
            0.51 * point_quantum + 1e-6);
}

TEST_F(HtmlReportTest, StencilsGiveTheLimitSurface) {
  const HtmlReport report = Report(1);
  const PageData data = Data(report);
  const LimitMesh limit =
      BuildLimitMesh(cage_->topology(), cage_->tags(), data.header["scene"]["levels"]);
  Points3d expected;
  ApplyStencils(limit.position, cage_->vertices(), &expected);
  const auto& sizes = data.arrays.at("row_sizes");
  ASSERT_EQ(static_cast<int64_t>(sizes.size()), expected.cols());
  size_t entry = 0;
  for (size_t row = 0; row < sizes.size(); ++row) {
    Eigen::Vector3d point = Eigen::Vector3d::Zero();
    uint32_t sum = 0;
    for (uint32_t k = 0; k < sizes[row]; ++k, ++entry) {
      const uint32_t weight = data.arrays.at("weights")[entry];
      point += weight / 65535.0 * cage_->vertices().col(data.arrays.at("columns")[entry]);
      sum += weight;
    }
    EXPECT_EQ(sum, 65535u);
    EXPECT_LT((point - expected.col(static_cast<int64_t>(row))).norm(), 1e-4);
  }
  EXPECT_EQ(entry, data.arrays.at("weights").size());
}

TEST_F(HtmlReportTest, DeviationsComeBackNearlyAsMeasured) {
  const HtmlReport report = Report(2);
  const PageData data = Data(report);
  const Scene scene = BuildScene(*cage_, report.frames);
  const double most = data.header["scene"]["most_deviation"];
  size_t at = 0;
  for (const SceneFrame& frame : scene.frames) {
    for (const double deviation : frame.point_deviations) {
      const double c = (data.arrays.at("point_deviations").at(at++) - 128.0) / 127;
      const double step = 2 * std::sqrt(most * std::abs(deviation)) / 127 + most / 127 / 127;
      EXPECT_NEAR(std::copysign(c * c, c) * most, deviation, step);
    }
  }
  EXPECT_EQ(at, data.arrays.at("point_deviations").size());
}

TEST_F(HtmlReportTest, HoldsEveryFrameOfTheReport) {
  const PageData data = Data(Report(4));
  ASSERT_EQ(data.header["report"]["frames"].size(), 4u);
  EXPECT_EQ(data.header["report"]["frames"][2]["error"]["message"], "frame");
  EXPECT_EQ(data.header["scene"]["frames"].size(), 3u);
}

TEST_F(HtmlReportTest, NothingInAReportBreaksOutOfItsPlace) {
  const std::string hostile =
      "</script><script>alert(1)</script><!-- ]]> {{data}} \xE2\x80\xA8 \xff '\"";
  const auto harmless = SplitPage(Written(Report(4)));
  const auto page = SplitPage(Written(Report(4, hostile)));
  EXPECT_EQ(page.shell, harmless.shell);
  EXPECT_EQ(page.data.find_first_not_of(
                "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/="),
            std::string::npos);
  const std::string message =
      ReadPayload(page.data).header["report"]["frames"][2]["error"]["message"];
  EXPECT_THAT(message, HasSubstr("</script><script>alert(1)</script><!--"));
}

TEST_F(HtmlReportTest, AsksForNoOtherFile) {
  const std::string html = Written(Report(1));
  for (const char* reference : {"<link", "<img", "<iframe", "<script src", "@import", "url("}) {
    EXPECT_EQ(Count(html, reference), 0) << reference;
  }
  EXPECT_THAT(html, HasSubstr("default-src 'none'"));
  // Each script ends where the page says, not within what was put into it.
  EXPECT_EQ(Count(html, "</script"), Count(std::string(PageFile("page.html")), "</script"));
  EXPECT_THAT(html, ::testing::EndsWith("</html>\n"));
}

TEST_F(HtmlReportTest, HoldsEveryFileOfThePage) {
  const std::string page(PageFile("page.html")), html = Written(Report(1));
  int files = 0;
  for (size_t at = page.find("{{"); at != std::string::npos; at = page.find("{{", at + 1)) {
    const std::string name = page.substr(at + 2, page.find("}}", at) - at - 2);
    if (name == "data") continue;
    ++files;
    EXPECT_FALSE(PageFile(name).empty()) << name;
    EXPECT_THAT(html, HasSubstr(std::string(PageFile(name)))) << name;
    EXPECT_THAT(html, Not(HasSubstr("{{" + name + "}}")));
  }
  EXPECT_GT(files, 10);
  EXPECT_THAT(html, HasSubstr("The MIT License"));
}

TEST_F(HtmlReportTest, IsThereWithoutAFit) {
  HtmlReport report = Report(3);
  report.cage = nullptr;
  report.frames.clear();
  const PageData data = Data(report);
  EXPECT_FALSE(data.header.contains("scene"));
  EXPECT_EQ(data.header["report"]["frames"].size(), 3u);
}

TEST_F(HtmlReportTest, SaysWhereTheTargetIsGone) {
  HtmlReport report = Report(1);
  report.frames.front().file = folder_ + "/gone.ply";
  const PageData data = Data(report);
  EXPECT_EQ(data.header["scene"]["frames"][0]["target_points"], 0);
  EXPECT_THAT(data.arrays.at("deviations"), Each(0u));
}

TEST_F(HtmlReportTest, ThirtyFramesWithoutAnyPatternStayBelowFiveMegabytes) {
  const TriangleMesh sphere = testing::Icosphere(3);
  const ControlMesh cage = ControlMesh::Create(sphere.vertices, sphere.triangles).value();
  HtmlReport report;
  report.cage = &cage;
  const std::string file = folder_ + "/target.ply";
  PointCloud target;
  target.points =
      (testing::Icosphere(5, 0.99).vertices + 0.01 * Points3d::Random(3, 10242)).cast<float>();
  ASSERT_EQ(WriteCloud(file, target), absl::OkStatus());
  for (size_t k = 0; k < 30; ++k) {
    vertices_.push_back(cage.vertices() + 0.01 * Points3d::Random(3, cage.vertex_count()));
    report.frames.push_back({k, file, &vertices_.back(), 1});
  }
  const std::string html = Written(report);
  EXPECT_LT(html.size(), 5'000'000u);
  EXPECT_EQ(ReadPayload(SplitPage(html).data).header["scene"]["frames"].size(), 30u);
}

}  // namespace
}  // namespace cagefit::client
