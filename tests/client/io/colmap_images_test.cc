#include <Eigen/Geometry>
#include <cmath>

#include "absl/strings/str_cat.h"
#include "client/io/camera_readers.h"
#include "tests/client/io/camera_samples.h"
#include "tests/client/io/expect_error.h"
#include "tests/support/spoiled_bytes.h"

namespace cagefit::client {
namespace {

absl::StatusOr<std::vector<Camera>> Read(const std::string& images) {
  return ReadColmapImages(images, ReadColmapCameras(kColmapCameras).value());
}

TEST(ColmapImagesTest, ReadsTheExampleOfTheDocumentation) {
  const auto cameras = Read(kColmapImages);
  ASSERT_TRUE(cameras.ok()) << cameras.status();
  ASSERT_EQ(cameras->size(), 2u);
  EXPECT_EQ((*cameras)[0].name, "P1180141.JPG");
  EXPECT_EQ((*cameras)[0].t, Eigen::Vector3d(-0.737434, 1.02973, 3.74354));
  EXPECT_EQ((*cameras)[0].fx, 2559.81);
  EXPECT_EQ((*cameras)[1].name, "rig/left #2.png");
  EXPECT_EQ((*cameras)[1].fx, 500);
}

// COLMAP's own formula for the rotation of a quaternion, written out.
TEST(ColmapImagesTest, TurnsWorldToCameraByTheQuaternion) {
  const double w = 0.851773, x = 0.0165051, y = 0.503764, z = -0.142941;
  Eigen::Matrix3d R;
  R << 1 - 2 * y * y - 2 * z * z, 2 * x * y - 2 * w * z, 2 * z * x + 2 * w * y,  //
      2 * x * y + 2 * w * z, 1 - 2 * x * x - 2 * z * z, 2 * y * z - 2 * w * x,   //
      2 * z * x - 2 * w * y, 2 * y * z + 2 * w * x, 1 - 2 * x * x - 2 * y * y;
  EXPECT_LT(((*Read(kColmapImages))[0].R - R).norm(), 1e-5);
  // A quarter turn about z takes the world's x to the camera's y.
  const auto turned = Read(absl::StrCat("1 ", M_SQRT1_2, " 0 0 ", M_SQRT1_2, " 0 0 2 1 a"));
  ASSERT_TRUE(turned.ok()) << turned.status();
  EXPECT_LT(((*turned)[0].R * Eigen::Vector3d::UnitX() - Eigen::Vector3d::UnitY()).norm(), 1e-6);
}

TEST(ColmapImagesTest, APixelCentreOfColmapIsOurs) {
  const Camera camera = (*Read("1 1 0 0 0 0 0 0 1 a"))[0];
  // COLMAP sees the axis at (1536, 1152), where four pixels meet.
  EXPECT_EQ(camera.Project({0, 0, 1}), Eigen::Vector3d(1535.5, 1151.5, 1));
}

TEST(ColmapImagesTest, LinesOfPointsMayBeBlankOrMissingAtTheEnd) {
  const auto cameras =
      Read("1 1 0 0 0 0 0 1 1 a\n\n2 1 0 0 0 0 0 1 1 b\r\n\r\n3 1 0 0 0 0 0 1 1 c");
  ASSERT_TRUE(cameras.ok()) << cameras.status();
  ASSERT_EQ(cameras->size(), 3u);
  EXPECT_EQ((*cameras)[1].name, "b");
  EXPECT_EQ((*cameras)[2].name, "c");
}

TEST(ColmapImagesTest, NoticesAnImageWhereItsPointsShouldBe) {
  EXPECT_INVALID(Read("1 1 0 0 0 0 0 1 1 a\n2 1 0 0 0 0 0 1 1 b\n"),
                 "line 2 is \"2 1 0 0 0 0 0 1 1 b\"; expected the points of the image above");
  // Twelve words, as of four points.
  EXPECT_INVALID(Read("1 1 0 0 0 0 0 1 1 a\n2 1 0 0 0 0 0 1 1 b c d\n"), "line 2 is");
}

TEST(ColmapImagesTest, NamesLineFieldAndValue) {
  const auto with = [](const std::string& line) {
    return Read(absl::StrCat("# heading\n1 1 0 0 0 0 0 1 1 a\n1 2 3\n", line));
  };
  EXPECT_INVALID(with("2 1 0 0 0 0 0 1 1"),
                 "line 4 is \"2 1 0 0 0 0 0 1 1\"; expected IMAGE_ID QW");
  EXPECT_INVALID(with("x 1 0 0 0 0 0 1 1 b"), "line 4: IMAGE_ID is \"x\"");
  EXPECT_INVALID(with("2 1 0 zero 0 0 0 1 1 b"), "line 4: QY is \"zero\"");
  EXPECT_INVALID(with("2 1 0 0 0 0 nan 1 1 b"), "line 4: TY is \"nan\"; expected a finite number");
  EXPECT_INVALID(with("2 0.5 0 0 0 0 0 1 1 b"),
                 "line 4: the length of QW QX QY QZ is \"0.5\"; expected 1");
  EXPECT_INVALID(with("2 1 0 0 0 0 0 1 5 b"),
                 "line 4: CAMERA_ID is \"5\"; expected one of those in cameras.txt");
  EXPECT_INVALID(with("2 1 0 0 0 0 0 1 1 a"), "line 4: NAME is \"a\"; expected one that no image");
  EXPECT_INVALID(Read("# none\n"), "no images");
}

TEST(ColmapImagesTest, SurvivesBrokenBytes) {
  const auto survives = [](const std::string& bytes) {
    const auto cameras = Read(bytes);
    EXPECT_TRUE(cameras.ok() || absl::IsInvalidArgument(cameras.status()));
  };
  testing::ForEachTruncation(kColmapImages, survives);
  testing::ForEachFlip(kColmapImages, 5000, 1, survives);
}

}  // namespace
}  // namespace cagefit::client
