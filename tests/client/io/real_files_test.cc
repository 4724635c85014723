// Real files of every format, with the numbers that their own sources give.
#include <gmock/gmock.h>

#include <algorithm>
#include <filesystem>

#include "client/io/file_bytes.h"
#include "client/io/geometry_file.h"
#include "tests/support/data.h"
#include "tests/support/temp_folder.h"

namespace cagefit::client {
namespace {

using ::testing::HasSubstr;

struct Loads {
  const char* file;
  int64_t vertices, polygons, normals;
};
constexpr Loads kModels[] = {
    {"static/3holes_3596.ply", 3596, 7200, 0},
    {"static/armadillo_49990.ply", 49990, 99976, 0},
    {"static/bunny_35947.ply", 35947, 69451, 0},
    {"static/bunny_closed_34835.ply", 34835, 69666, 0},
    {"static/cgal_3torus.ply", 19, 46, 0},
    {"static/cgal_eight.ply", 315, 634, 0},
    {"static/cgal_elephant_with_holes.ply", 2798, 4463, 0},
    {"static/cgal_knot2.ply", 5760, 11520, 0},
    {"static/face_25905.ply", 25905, 51712, 0},
    {"static/fandisk_6475.ply", 6475, 12946, 0},
    {"static/fish_10786.ply", 10786, 21568, 0},
    {"static/hemisphere_1861.ply", 1861, 3600, 0},
    {"static/human_man_6890.ply", 6890, 13776, 0},
    {"static/koala_49999.ply", 49999, 99994, 0},
    {"static/plane_holes_8519.ply", 8519, 16747, 0},
    {"static/sphere_642.ply", 642, 1280, 0},
    {"static/spot_11533.ply", 11533, 23062, 0},
    {"static/spot_2930.ply", 2930, 5856, 0},
    {"static/torus_2304.ply", 2304, 4608, 0},
    {"static/wingnut_3047.ply", 3047, 6090, 0},
    {"scans/bunny_72027_resampled.ply", 72027, 0, 72027},
    {"scans/bunny_raw_362272.ply", 362272, 0, 362272},
    {"scans/cgal_hippo1.ply", 6104, 0, 6104},
    {"scans/cgal_hippo2.ply", 4387, 0, 4387},
    {"scans/cgal_kitten.ply", 5210, 0, 5210},
    {"scans/cgal_oni.ply", 1435, 0, 1435},
    {"scans/cgal_sphere_20k.ply", 21000, 0, 21000},
    {"scans/lion_takanawa_341989.ply", 341989, 0, 341989},
    {"scans/pcl_kinect_table_scene.ply", 241407, 0, 0},
    {"scans/pcl_milk_carton.ply", 12575, 0, 0},
    {"control/bunny_314.obj", 314, 624, 0},
    {"control/bunny_3301.obj", 3301, 6598, 3301},
    {"control/fish_lowres.obj", 945, 1886, 945},
    {"control/hand_lowres_810.obj", 810, 1602, 0},
    {"control/koala_3560.obj", 3560, 7116, 0},
    {"control/spot_829.obj", 829, 1654, 829},
    {"control/spot_control_mesh.obj", 188, 180, 0},
};
constexpr Loads kFormats[] = {
    {"formats/cgal_blobby_3cc.off", 1820, 3417, 0},
    {"formats/cgal_colored_tetra.ply", 4, 4, 4},
    {"formats/cgal_cube-shuffled.off", 8, 12, 0},
    {"formats/cgal_degtri_sliding.off", 8, 8, 0},
    {"formats/cgal_mesh_with_colors.off", 8, 4, 0},
    {"formats/cgal_mpi.off", 90, 52, 0},
    {"formats/cgal_negative.off", 7, 6, 0},
    {"formats/cgal_open_cube.off", 8, 10, 0},
    {"formats/cgal_pig.off", 468, 891, 0},
    {"formats/cgal_quads_to_stitch.off", 20, 8, 0},
    {"formats/cgal_tetra_intersected_by_triangle.off", 7, 5, 0},
    {"formats/cgal_torus_quad.off", 25, 25, 0},
    {"formats/cgal_triangular_hole.off", 6, 6, 0},
    {"formats/draco_cube_quads.obj", 8, 6, 8},
    {"formats/draco_cube_quads.ply", 8, 6, 0},
    {"formats/draco_deg_faces.obj", 6, 4, 0},
    {"formats/draco_degenerate_mesh.obj", 3, 1, 0},
    {"formats/draco_delim_test.ply", 24, 8, 24},
    {"formats/draco_empty_name.obj", 3, 1, 0},
    {"formats/draco_eof_test.obj", 3, 1, 0},
    {"formats/draco_extra_vertex.obj", 10, 3, 10},
    {"formats/draco_int_point_cloud.ply", 16, 0, 0},
    {"formats/draco_multiple_isolated_triangles.obj", 15, 5, 0},
    {"formats/draco_multiple_tetrahedrons.obj", 20, 20, 0},
    {"formats/draco_non_manifold_wrap.obj", 10, 12, 0},
    {"formats/draco_octagon_preserved.obj", 8, 1, 0},
    {"formats/draco_test_extra_whitespace.ply", 3, 1, 0},
    {"formats/draco_test_lines.obj", 484, 0, 0},
    {"formats/draco_test_more_datatypes.ply", 3, 1, 0},
    {"formats/draco_test_pos_color.ply", 114, 224, 0},
    {"formats/draco_test_pos_color_ascii.ply", 114, 224, 0},
    {"formats/draco_two_faces_312.obj", 6, 2, 0},
    {"formats/pcl_lamppost_ascii.pcd", 1771, 0, 0},
    {"formats/pcl_milk_binary_compressed.pcd", 12575, 0, 0},
    {"formats/pcl_object_template_ascii_pad.pcd", 1397, 0, 0},
};

struct Fails {
  const char* file;
  const char* part;  // of the message
};
constexpr Fails kBadFormats[] = {
    {"bv_header_lies.ply",
     "line 5 is \"float x\"; expected format, comment, element, property or end_header"},
    {"draco_float_inf_point_cloud.ply", "vertex 0 (from 0) is not finite: -409 249 inf"},
    {"draco_inf_nan.obj", "vertex 0 (from 0) is not finite: inf nan inf"},
    {"draco_test_wrong_attribute_mapping.obj", "line 4 names normal 1 of 0"},
};

int64_t FilesIn(const std::string& folder) {
  const std::filesystem::directory_iterator entries(testing::DataDir() + "/" + folder);
  return std::distance(begin(entries), end(entries));
}

void ExpectLoads(const Loads& expected) {
  const auto geometry = ReadGeometry(testing::DataDir() + "/" + expected.file);
  ASSERT_TRUE(geometry.ok()) << geometry.status();
  EXPECT_EQ(geometry->mesh.vertices.cols(), expected.vertices) << expected.file;
  EXPECT_EQ(geometry->polygons, expected.polygons) << expected.file;
  EXPECT_EQ(geometry->normals.cols(), expected.normals) << expected.file;
}

TEST(RealFilesTest, ModelsScansAndCagesLoadWithTheirCounts) {
  CAGEFIT_NEEDS_DATA();
  for (const Loads& expected : kModels) ExpectLoads(expected);
  EXPECT_EQ(std::size(kModels), FilesIn("static") + FilesIn("scans") + FilesIn("control"));
}

TEST(RealFilesTest, EveryFormatLoadsOrSaysWhatIsWrong) {
  CAGEFIT_NEEDS_DATA();
  for (const Loads& expected : kFormats) ExpectLoads(expected);
  for (const Fails& expected : kBadFormats) {
    const std::string path = testing::DataDir() + "/formats/" + expected.file;
    const auto geometry = ReadGeometry(path);
    EXPECT_EQ(geometry.status().code(), absl::StatusCode::kInvalidArgument) << expected.file;
    EXPECT_THAT(std::string(geometry.status().message()), HasSubstr(path + ": "));
    EXPECT_THAT(std::string(geometry.status().message()), HasSubstr(expected.part));
  }
  EXPECT_EQ(std::size(kFormats) + std::size(kBadFormats), FilesIn("formats"));
}

TEST(RealFilesTest, SequencesLoadWithTheirCounts) {
  CAGEFIT_NEEDS_DATA();
  const std::string data = testing::DataDir();
  for (const auto& entry : std::filesystem::directory_iterator(data + "/sequences/bv_points16")) {
    const auto geometry = ReadGeometry(entry.path());
    ASSERT_TRUE(geometry.ok()) << geometry.status();
    EXPECT_GE(geometry->mesh.vertices.cols(), 13'500);
    EXPECT_LE(geometry->mesh.vertices.cols(), 13'795);
    EXPECT_TRUE(geometry->is_cloud());
  }
  ExpectLoads({"tshirt/template.ply", 1981, 3844, 0});
  ExpectLoads({"puppet/template.ply", 11533, 23062, 0});
  for (const auto& entry : std::filesystem::directory_iterator(data + "/tshirt/drc")) {
    const auto geometry = ReadGeometry(entry.path());
    ASSERT_TRUE(geometry.ok()) << geometry.status();
    EXPECT_EQ(geometry->mesh.vertices.cols(), 100'000);
    EXPECT_EQ(geometry->normals.cols(), 100'000);
  }
}

// Damaged copies of real files, the short form of fuzzing.
TEST(RealFilesTest, DamagedCopiesNeverBreakTheReaders) {
  CAGEFIT_NEEDS_DATA();
  uint32_t random = 12345;
  const auto next = [&random] { return random = 1664525 * random + 1013904223; };
  for (const Loads& source : kFormats) {
    const std::string bytes = *ReadFileBytes(testing::DataDir() + "/" + source.file, 1 << 24);
    const std::string path =
        cagefit::testing::TempFolder() + "damaged" + FileExtension(source.file);
    for (int round = 0; round < 20; ++round) {
      std::string damaged = bytes.substr(0, next() % bytes.size());
      if (round % 2 == 0) damaged = bytes;
      const size_t reach = std::min<size_t>(damaged.size(), round % 4 == 0 ? 400 : damaged.size());
      for (uint32_t k = 1 + (next() >> 16) % 4; k > 0 && reach > 0; --k) {
        damaged[(next() >> 8) % reach] = static_cast<char>(next() >> 24);
      }
      ASSERT_TRUE(WriteFileBytes(path, damaged).ok());
      const auto geometry = ReadGeometry(path);
      if (geometry.ok()) {
        EXPECT_TRUE(geometry->mesh.vertices.allFinite()) << source.file;
      }
    }
  }
}

}  // namespace
}  // namespace cagefit::client
