#include "client/io/picture.h"

#include <gtest/gtest.h>

namespace cagefit::client {
namespace {

TEST(PictureTest, NearDepthsAreBright) {
  Image depth(4, 1);
  depth.values = {0, 2, 3, 4};
  const Image picture = DepthPicture(depth);
  EXPECT_EQ(picture.values[0], 0);
  EXPECT_FLOAT_EQ(picture.values[1], 1);
  EXPECT_FLOAT_EQ(picture.values[2], 0.55F);
  EXPECT_FLOAT_EQ(picture.values[3], 0.1F);
}

TEST(PictureTest, OneDepthAloneIsBright) {
  Image depth(2, 1);
  depth.values = {0, 7};
  EXPECT_EQ(DepthPicture(depth).values, (std::vector<float>{0, 1}));
}

TEST(PictureTest, NormalsBecomeColours) {
  Image normals(2, 1, 3);
  normals.values = {0, 0, 0, -1, 0, 0.5F};
  EXPECT_EQ(NormalPicture(normals).values, (std::vector<float>{0, 0, 0, 0, 0.5F, 0.75F}));
}

}  // namespace
}  // namespace cagefit::client
