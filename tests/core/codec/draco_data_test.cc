// Real Draco files of many encoders and versions, and files made to break decoders.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <vector>

#include "core/codec/draco_codec.h"
#include "tests/core/codec/measured_child.h"
#include "tests/support/data.h"
#include "tests/support/sanitizer.h"

namespace cagefit {
namespace {

std::string ReadBytes(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream bytes;
  bytes << file.rdbuf();
  return bytes.str();
}

DecodeLimits FileLimits() {
  DecodeLimits limits;
  limits.allow_metadata = true;
  return limits;
}

struct Counts {
  const char* file;
  int points, faces, normals;
};

// What Draco 1.5.5's own decoder gives.
constexpr Counts kValid[] = {
    {"bunny.drc", 34834, 69451, 0},
    {"bunny_gltf.drc", 34834, 69451, 34834},
    {"car.drc", 1856, 1744, 1856},
    {"cube_att.drc", 24, 12, 24},
    {"cube_att.obj.edgebreaker.cl10.2.2.drc", 24, 12, 24},
    {"cube_att.obj.edgebreaker.cl4.2.2.drc", 24, 12, 24},
    {"cube_att.obj.sequential.cl3.2.2.drc", 24, 12, 24},
    {"cube_att_sub_o_2.drc", 26, 12, 26},
    {"cube_att_sub_o_no_metadata.drc", 26, 12, 26},
    {"cube_pc.drc", 24, 0, 24},
    {"octagon_preserved.drc", 16, 6, 0},
    {"pc_color.drc", 7733, 0, 0},
    {"pc_kd_color.drc", 7733, 0, 0},
    {"point_cloud_no_qp.drc", 21, 0, 0},
    {"test_nm.obj.edgebreaker.0.10.0.drc", 99, 170, 99},
    {"test_nm.obj.edgebreaker.0.9.1.drc", 99, 170, 99},
    {"test_nm.obj.edgebreaker.1.0.0.drc", 99, 170, 99},
    {"test_nm.obj.edgebreaker.1.1.0.drc", 99, 170, 99},
    {"test_nm.obj.edgebreaker.cl10.2.2.drc", 99, 170, 99},
    {"test_nm.obj.edgebreaker.cl4.2.2.drc", 99, 170, 99},
    {"test_nm.obj.sequential.0.10.0.drc", 97, 170, 97},
    {"test_nm.obj.sequential.0.9.1.drc", 97, 170, 97},
    {"test_nm.obj.sequential.1.0.0.drc", 97, 170, 97},
    {"test_nm.obj.sequential.1.1.0.drc", 97, 170, 97},
    {"test_nm.obj.sequential.cl3.2.2.drc", 97, 170, 97},
    {"test_nm_quant.0.9.0.drc", 99, 170, 99},
};

TEST(DracoDataTest, ValidFilesLoadWithTheirCounts) {
  CAGEFIT_NEEDS_DATA();
  const std::filesystem::path folder = testing::DataDir() + "/draco/valid";
  int files = 0;
  for (const Counts& expected : kValid) {
    Points3f normals;
    const auto mesh = DecodeDracoMesh(ReadBytes(folder / expected.file), FileLimits(), &normals);
    ASSERT_TRUE(mesh.ok()) << expected.file << ": " << mesh.status();
    EXPECT_EQ(mesh->vertices.cols(), expected.points) << expected.file;
    EXPECT_EQ(mesh->triangles.cols(), expected.faces) << expected.file;
    EXPECT_EQ(normals.cols(), expected.normals) << expected.file;
    ++files;
  }
  const std::filesystem::directory_iterator in_folder(folder);
  EXPECT_EQ(files, std::distance(begin(in_folder), end(in_folder)));
}

TEST(DracoDataTest, ValidFilesGiveClouds) {
  CAGEFIT_NEEDS_DATA();
  for (const Counts& expected : kValid) {
    const std::string bytes = ReadBytes(testing::DataDir() + "/draco/valid/" + expected.file);
    const auto cloud = DecodeDracoCloud(bytes, FileLimits());
    ASSERT_TRUE(cloud.ok()) << expected.file << ": " << cloud.status();
    EXPECT_TRUE(cloud->points.allFinite()) << expected.file;
    const bool is_mesh = expected.faces > 0;
    EXPECT_EQ(cloud->has_normals(), is_mesh || expected.normals > 0) << expected.file;
    // A mesh without normals loses its vertices without a face of positive area.
    if (!is_mesh || expected.normals > 0) {
      EXPECT_EQ(cloud->size(), expected.points) << expected.file;
    }
  }
}

// file -> whether Draco's plain decoder gives a sound geometry.
std::map<std::string, bool> ReadExpectations(const std::filesystem::path& csv) {
  std::map<std::string, bool> expected;
  std::ifstream lines(csv);
  std::string line;
  std::getline(lines, line);
  while (std::getline(lines, line)) {
    const bool decoded = line.find("\"decoded points=") != std::string::npos &&
                         line.find("NON-FINITE") == std::string::npos;
    expected[line.substr(0, line.find(','))] = decoded;
  }
  return expected;
}

TEST(DracoDataTest, MalformedFilesLoadOrFailCheaply) {
  CAGEFIT_NEEDS_DATA();
  const std::filesystem::path folder = testing::DataDir() + "/draco/malformed";
  const std::map<std::string, bool> expected = ReadExpectations(folder / "EXPECTED.csv");
  ASSERT_EQ(expected.size(), 232u);
  enum Outcome { kLoads, kInvalid, kTooMuch, kOther };
  for (const auto& [file, loads] : expected) {
    const std::string bytes = ReadBytes(folder / file);
    const testing::ChildReport report = testing::RunInChild([&] {
      const auto mesh = DecodeDracoMesh(bytes, FileLimits());
      if (mesh.ok()) return kLoads;
      if (absl::IsInvalidArgument(mesh.status())) return kInvalid;
      return absl::IsResourceExhausted(mesh.status()) ? kTooMuch : kOther;
    });
    EXPECT_EQ(report.signal, 0) << file;
    EXPECT_NE(report.exit_code, kOther) << file;
    EXPECT_EQ(report.exit_code == kLoads, loads) << file;
    EXPECT_LT(report.cpu_ms, 250 * testing::kCostFactor) << file;
    EXPECT_LT(report.peak_mib, 256 * testing::kCostFactor) << file;
  }
}

TEST(DracoDataTest, CapturesDecodeWithTheirPointsAndNormals) {
  CAGEFIT_NEEDS_DATA();
  for (int frame = 0; frame < 30; frame += 7) {
    char name[32];
    std::snprintf(name, sizeof(name), "frame_%03d.drc", frame);
    const auto shirt = DecodeDracoCloud(ReadBytes(testing::DataDir() + "/tshirt/drc/" + name), {});
    ASSERT_TRUE(shirt.ok()) << name << ": " << shirt.status();
    EXPECT_EQ(shirt->size(), 100'000) << name;
    EXPECT_EQ(shirt->normals.cols(), 100'000) << name;
    const auto puppet = DecodeDracoMesh(ReadBytes(testing::DataDir() + "/puppet/drc/" + name), {});
    ASSERT_TRUE(puppet.ok()) << name << ": " << puppet.status();
    EXPECT_GE(puppet->vertices.cols(), 123'226) << name;
    EXPECT_LE(puppet->vertices.cols(), 129'800) << name;
  }
}

}  // namespace
}  // namespace cagefit
