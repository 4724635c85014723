#include "absl/strings/str_cat.h"
#include "client/io/camera_readers.h"
#include "tests/client/io/camera_samples.h"
#include "tests/client/io/expect_error.h"
#include "tests/support/spoiled_bytes.h"

namespace cagefit::client {
namespace {

Camera ReadOne(const std::string& line) {
  const auto cameras = ReadColmapCameras(line);
  EXPECT_TRUE(cameras.ok()) << cameras.status();
  return cameras.ok() ? cameras->begin()->second : Camera();
}

TEST(ColmapCamerasTest, ReadsTheExampleOfTheDocumentation) {
  const auto cameras = ReadColmapCameras(kColmapCameras);
  ASSERT_TRUE(cameras.ok()) << cameras.status();
  ASSERT_EQ(cameras->size(), 4u);
  const Camera& simple = cameras->at(1);
  EXPECT_EQ(simple.width, 3072);
  EXPECT_EQ(simple.height, 2304);
  EXPECT_EQ(simple.fx, 2559.81);
  EXPECT_EQ(simple.fy, 2559.81);
  EXPECT_EQ(cameras->at(2).fx, 2560.56);
  EXPECT_EQ(cameras->at(2).fy, 2561.5);
  EXPECT_EQ(cameras->at(3).distortion.k1, -0.0218531);
}

// COLMAP's principal point 1536 is the middle of 3072 pixels; ours is 1535.5, between the pixels
// 1535 and 1536.
TEST(ColmapCamerasTest, MovesPixelCentresToWholeNumbers) {
  const Camera camera = ReadOne("1 SIMPLE_PINHOLE 3072 2304 2559.81 1536 1152");
  EXPECT_EQ(camera.cx, 1535.5);
  EXPECT_EQ(camera.cy, 1151.5);
}

TEST(ColmapCamerasTest, ReadsEveryLens) {
  const Camera radial = ReadOne("1 RADIAL 640 480 500 320 240 0.1 0.2");
  EXPECT_EQ(radial.fy, 500);
  EXPECT_EQ(radial.distortion.k1, 0.1);
  EXPECT_EQ(radial.distortion.k2, 0.2);
  const Camera full =
      ReadOne("1 FULL_OPENCV 640 480 500 510 320 240 0.1 0.2 0.03 0.04 0.5 0 0.0 -0");
  EXPECT_EQ(full.fx, 500);
  EXPECT_EQ(full.fy, 510);
  EXPECT_EQ(full.cx, 319.5);
  EXPECT_EQ(full.cy, 239.5);
  EXPECT_EQ(full.distortion.k1, 0.1);
  EXPECT_EQ(full.distortion.k2, 0.2);
  EXPECT_EQ(full.distortion.p1, 0.03);
  EXPECT_EQ(full.distortion.p2, 0.04);
  EXPECT_EQ(full.distortion.k3, 0.5);
  const Camera opencv = ReadColmapCameras(kColmapCameras)->at(7);
  EXPECT_EQ(opencv.distortion.p1, 2e-4);
  EXPECT_EQ(opencv.distortion.p2, -5e-4);
  EXPECT_EQ(opencv.distortion.k3, 0);
}

TEST(ColmapCamerasTest, NamesTheModelThatIsNotRead) {
  EXPECT_INVALID(ReadColmapCameras("\n1 OPENCV_FISHEYE 640 480 5 5 3 2 0 0 0 0"),
                 "line 2: MODEL is \"OPENCV_FISHEYE\"; expected SIMPLE_PINHOLE, PINHOLE, ");
  EXPECT_INVALID(ReadColmapCameras("1 FULL_OPENCV 640 480 5 5 3 2 0 0 0 0 0 0 1e-3 0"),
                 "line 1: k5 is \"1e-3\"; expected 0");
}

TEST(ColmapCamerasTest, NamesLineFieldAndValue) {
  const auto with = [](const std::string& line) {
    return ReadColmapCameras(absl::StrCat("# heading\n1 PINHOLE 9 9 5 5 4 4\n", line));
  };
  EXPECT_INVALID(with("2 PINHOLE 640"), "line 3 is \"2 PINHOLE 640\"; expected CAMERA_ID MODEL");
  EXPECT_INVALID(with("x PINHOLE 640 480 5 5 3 2"), "line 3: CAMERA_ID is \"x\"");
  EXPECT_INVALID(with("2 PINHOLE 6.5 480 5 5 3 2"), "line 3: WIDTH is \"6.5\"");
  EXPECT_INVALID(with("2 PINHOLE 640 9999999999 5 5 3 2"), "line 3: HEIGHT is \"9999999999\"");
  EXPECT_INVALID(with("2 PINHOLE 640 20000 5 5 3 2"), "line 3: camera \"2\": height is 20000");
  EXPECT_INVALID(with("2 PINHOLE 640 480 5 5 3"),
                 "line 3: the number of PARAMS of PINHOLE is \"3\"; expected 4: fx fy cx cy");
  EXPECT_INVALID(with("2 PINHOLE 640 480 5 inf 3 2"), "line 3: fy is \"inf\"");
  EXPECT_INVALID(with("2 PINHOLE 640 480 5 -5 3 2"), "line 3: camera \"2\": fy is -5");
  EXPECT_INVALID(with("1 PINHOLE 640 480 5 5 3 2"),
                 "line 3: CAMERA_ID is \"1\"; expected one that");
  EXPECT_INVALID(ReadColmapCameras("# none\n"), "no cameras");
}

TEST(ColmapCamerasTest, SurvivesBrokenBytes) {
  const auto survives = [](const std::string& bytes) {
    const auto cameras = ReadColmapCameras(bytes);
    EXPECT_TRUE(cameras.ok() || absl::IsInvalidArgument(cameras.status()));
  };
  testing::ForEachTruncation(kColmapCameras, survives);
  testing::ForEachFlip(kColmapCameras, 5000, 1, survives);
}

}  // namespace
}  // namespace cagefit::client
