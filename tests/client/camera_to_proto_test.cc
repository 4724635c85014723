#include "client/camera_to_proto.h"

#include <gtest/gtest.h>

#include <tuple>

#include "server/transport/session_convert.h"
#include "tests/support/frames.h"

namespace cagefit::client {
namespace {

// What the server gives back is what it understood.
TEST(CameraToProtoTest, TheServerReadsEveryFieldAsItWas) {
  Camera camera = LookAt({1, 2, 3}, {0, 0.5, 0}, {0, 0, 1}, 0.7, 640);
  camera.name = "left";
  camera.height = 480;
  camera.fy = 700;
  camera.distortion = {0.1, 0.2, 0.3, 0.4, 0.5};
  v1::CreateSessionRequest request;
  *request.mutable_control_mesh() = server::ToProto(cagefit::testing::FrameCage());
  *request.mutable_options()->add_cameras() = ToProto(camera);
  const auto config = server::FromProto(request, server::SessionLimits());
  ASSERT_TRUE(config.ok()) << config.status();
  const Camera& read = config->cameras[0];
  EXPECT_EQ(read.R, camera.R);
  EXPECT_EQ(read.t, camera.t);
  EXPECT_EQ(std::tie(read.name, read.width, read.height, read.fx, read.fy, read.cx, read.cy),
            std::tie(camera.name, camera.width, camera.height, camera.fx, camera.fy, camera.cx,
                     camera.cy));
  EXPECT_EQ(read.distortion.k1, 0.1);
  EXPECT_EQ(read.distortion.k2, 0.2);
  EXPECT_EQ(read.distortion.p1, 0.3);
  EXPECT_EQ(read.distortion.p2, 0.4);
  EXPECT_EQ(read.distortion.k3, 0.5);
}

}  // namespace
}  // namespace cagefit::client
