#include "client/commands/render_views.h"

#include <gmock/gmock.h>

#include "client/io/camera_file.h"
#include "tests/support/shapes.h"
#include "tests/support/temp_folder.h"

namespace cagefit::client {
namespace {

using ::testing::HasSubstr;

Points3d Ball() { return cagefit::testing::Icosphere(2, 3).vertices; }

std::string CamerasNamed(const std::string& first, const std::string& second) {
  const std::string path = cagefit::testing::TempFolder() + "render_views.json";
  Camera camera = LookAt({0, 0, 5}, {0, 0, 0}, {0, 1, 0}, 1, 640);
  camera.height = 480;
  camera.name = first;
  camera.distortion.k1 = -0.1;
  Camera other = camera;
  other.name = second;
  EXPECT_TRUE(WriteCameras(path, {camera, other}).ok());
  return path;
}

TEST(RenderViewsTest, VirtualCamerasSeeAllOfTheMesh) {
  for (const char* layout : {"sphere", "tutorial"}) {
    ViewOptions options;
    options.layout = layout;
    options.count = 12;
    const Points3d vertices = Ball().colwise() + Eigen::Vector3d(5, 6, 7);
    const auto views = ChooseViews(options, vertices);
    ASSERT_TRUE(views.ok()) << views.status();
    ASSERT_EQ(views->size(), 12u);
    EXPECT_EQ((*views)[11].name, "view_0011");
    for (const Camera& view : *views) {
      EXPECT_EQ(view.width, 256);
      for (Eigen::Index i = 0; i < vertices.cols(); ++i) {
        const Eigen::Vector3d p = view.Project(vertices.col(i));
        EXPECT_TRUE(p[2] > 0 && p[0] > -0.5 && p[0] < 255.5 && p[1] > -0.5 && p[1] < 255.5);
      }
    }
  }
}

TEST(RenderViewsTest, GivenCamerasKeepTheirSizeUnlessOneIsAskedFor) {
  ViewOptions options;
  options.cameras = CamerasNamed("rig/left.PNG", "..");
  const auto views = ChooseViews(options, Ball());
  ASSERT_TRUE(views.ok()) << views.status();
  ASSERT_EQ(views->size(), 2u);
  EXPECT_EQ((*views)[0].name, "rig_left");
  EXPECT_EQ((*views)[1].name, "_.");
  EXPECT_EQ((*views)[0].width, 640);
  EXPECT_TRUE((*views)[0].distortion.is_zero());
  options.size = 320;
  EXPECT_EQ((*ChooseViews(options, Ball()))[0].height, 240);
}

TEST(RenderViewsTest, RefusesNamesThatBecomeTheSame) {
  ViewOptions options;
  options.cameras = CamerasNamed("a/b", "a_b.png");
  EXPECT_THAT(std::string(ChooseViews(options, Ball()).status().message()),
              HasSubstr("two cameras would write to files of the name a_b"));
}

TEST(RenderViewsTest, RefusesAMeshWithoutExtent) {
  EXPECT_EQ(ChooseViews({}, Points3d::Zero(3, 4)).status().code(),
            absl::StatusCode::kInvalidArgument);
}

}  // namespace
}  // namespace cagefit::client
