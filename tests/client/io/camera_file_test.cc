#include "client/io/camera_file.h"

#include <filesystem>

#include "client/io/file_bytes.h"
#include "tests/client/io/camera_samples.h"
#include "tests/client/io/expect_error.h"
#include "tests/support/temp_folder.h"

namespace cagefit::client {
namespace {

// An empty folder of that name.
std::string TempFolder(const std::string& name) {
  const std::string path = cagefit::testing::TempFolder() + name;
  std::filesystem::remove_all(path);
  std::filesystem::create_directories(path);
  return path;
}

TEST(CameraFileTest, ReadsTheCamerasThatItWrote) {
  const std::string folder = TempFolder("camera_file_json");
  ASSERT_TRUE(WriteFileBytes(folder + "/in.json", kCamerasJson).ok());
  const auto cameras = ReadCameras(folder + "/in.json");
  ASSERT_TRUE(cameras.ok()) << cameras.status();
  ASSERT_TRUE(WriteCameras(folder + "/out.json", *cameras).ok());
  const auto again = ReadCameras(folder + "/out.json");
  ASSERT_TRUE(again.ok()) << again.status();
  ASSERT_EQ(again->size(), 2u);
  EXPECT_EQ((*again)[0].name, "left");
  EXPECT_EQ((*again)[0].R, (*cameras)[0].R);
}

TEST(CameraFileTest, ReadsAFolderOfColmap) {
  const std::string folder = TempFolder("camera_file_colmap");
  ASSERT_TRUE(WriteFileBytes(folder + "/cameras.txt", kColmapCameras).ok());
  ASSERT_TRUE(WriteFileBytes(folder + "/images.txt", kColmapImages).ok());
  for (const std::string& path : {folder, folder + "/"}) {
    const auto cameras = ReadCameras(path);
    ASSERT_TRUE(cameras.ok()) << cameras.status();
    ASSERT_EQ(cameras->size(), 2u);
    EXPECT_EQ((*cameras)[0].name, "P1180141.JPG");
  }
}

TEST(CameraFileTest, ErrorsNameTheFile) {
  const std::string folder = TempFolder("camera_file_errors");
  EXPECT_EQ(ReadCameras(folder + "/none.json").status().code(), absl::StatusCode::kNotFound);
  EXPECT_EQ(ReadCameras(folder).status().message(), folder + "/cameras.txt: there is no such file");
  ASSERT_TRUE(WriteFileBytes(folder + "/bad.json", "{").ok());
  EXPECT_INVALID(ReadCameras(folder + "/bad.json"), folder + "/bad.json: parse error at line 1");
  ASSERT_TRUE(WriteFileBytes(folder + "/cameras.txt", "1 FOV 6 4 5 5 3 2 0").ok());
  EXPECT_INVALID(ReadCameras(folder), folder + "/cameras.txt: line 1: MODEL is \"FOV\"");
  ASSERT_TRUE(WriteFileBytes(folder + "/cameras.txt", kColmapCameras).ok());
  ASSERT_TRUE(WriteFileBytes(folder + "/images.txt", "1 1 0 0 0 0 0 1 9 a").ok());
  EXPECT_INVALID(ReadCameras(folder), folder + "/images.txt: line 1: CAMERA_ID is \"9\"");
  EXPECT_EQ(std::string(WriteCameras(folder + "/out.json", {}).message()),
            folder + "/out.json: there are no cameras to write");
}

TEST(CameraFileTest, SaysHowToReadABinaryModel) {
  const std::string folder = TempFolder("camera_file_binary");
  ASSERT_TRUE(WriteFileBytes(folder + "/cameras.bin", "x").ok());
  EXPECT_INVALID(ReadCameras(folder), "model_converter --output_type TXT");
}

}  // namespace
}  // namespace cagefit::client
