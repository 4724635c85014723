#include <Eigen/Geometry>

#include "client/io/camera_readers.h"
#include "tests/client/io/camera_samples.h"
#include "tests/client/io/expect_error.h"
#include "tests/support/spoiled_bytes.h"

namespace cagefit::client {
namespace {

// The sample with its first `from` replaced.
absl::StatusOr<std::vector<Camera>> ReadWith(const std::string& from, const std::string& to) {
  std::string text = kCamerasJson;
  const size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return ReadCamerasJson(text.replace(at, from.size(), to));
}

TEST(CameraJsonTest, ReadsEveryField) {
  const auto cameras = ReadCamerasJson(kCamerasJson);
  ASSERT_TRUE(cameras.ok()) << cameras.status();
  ASSERT_EQ(cameras->size(), 2u);
  const Camera& left = (*cameras)[0];
  EXPECT_EQ(left.name, "left");
  EXPECT_EQ(left.width, 640);
  EXPECT_EQ(left.height, 480);
  EXPECT_EQ(left.fx, 500.5);
  EXPECT_EQ(left.fy, 510.25);
  EXPECT_EQ(left.cx, 319.5);
  EXPECT_EQ(left.cy, 239.5);
  EXPECT_EQ(left.R * Eigen::Vector3d(1, 2, 3), Eigen::Vector3d(-2, 1, 3));
  EXPECT_EQ(left.t, Eigen::Vector3d(0.1, -0.2, 3));
  EXPECT_EQ(left.distortion.k1, -0.28);
  EXPECT_EQ(left.distortion.k2, 0.07);
  EXPECT_EQ(left.distortion.p1, 0.0002);
  EXPECT_EQ(left.distortion.p2, -0.0005);
  EXPECT_EQ(left.distortion.k3, 0.01);
  EXPECT_EQ((*cameras)[1].name, "right");
  EXPECT_TRUE((*cameras)[1].distortion.is_zero());
}

TEST(CameraJsonTest, FieldsOfTheDistortionMayBeLeftOut) {
  const auto cameras = ReadWith(R"("k1": -0.28, )", "");
  ASSERT_TRUE(cameras.ok()) << cameras.status();
  EXPECT_EQ((*cameras)[0].distortion.k1, 0);
  EXPECT_EQ((*cameras)[0].distortion.k2, 0.07);
}

TEST(CameraJsonTest, NamesCameraFieldAndValueOfABadK) {
  EXPECT_INVALID(ReadWith("[[500.5, 0,", "[[500.5, 0.5,"),
                 "camera \"left\": K[0][1] is 0.5; expected 0");
  EXPECT_INVALID(ReadWith("[0, 510.25,", "[1, 510.25,"),
                 "camera \"left\": K[1][0] is 1.0; expected 0");
  EXPECT_INVALID(ReadWith("[0, 0, 1]]", "[0, 0, 2]]"),
                 "camera \"left\": K[2][2] is 2.0; expected 1");
  EXPECT_INVALID(ReadWith("[0, 0, 1]]", "[0, 0]]"),
                 "camera \"left\": K[2] is an array of 2; expected");
  EXPECT_INVALID(ReadWith("500.5", "\"500.5\""),
                 "camera \"left\": K[0][0] is \"500.5\"; expected a number");
  EXPECT_INVALID(ReadWith("500.5", "-3"), "camera \"left\": fx is -3");
}

TEST(CameraJsonTest, NamesFieldsThatAreUnknownMissingOrThereTwice) {
  EXPECT_INVALID(ReadWith("\"width\": 640", "\"widht\": 640"),
                 "camera \"left\": there is no field \"widht\" (its value is 640)");
  EXPECT_INVALID(ReadWith("\"k1\"", "\"k4\""),
                 "camera \"left\", distortion: there is no field \"k4\" (its value is -0.28)");
  EXPECT_INVALID(ReadWith("{\"cameras\"", "{\"scale\": [2], \"cameras\""),
                 "there is no field \"scale\" (its value is an array of 1)");
  EXPECT_INVALID(ReadWith("\"width\": 640, ", ""), "camera \"left\": has no field \"width\"");
  EXPECT_INVALID(ReadWith("\"name\": \"right\", ", ""), "camera 1 (from 0): has no field \"name\"");
  EXPECT_INVALID(ReadWith("\"width\": 640", "\"width\": 640, \"width\": 641"),
                 "an object has the field \"width\" twice");
  EXPECT_INVALID(ReadWith("0.01}}", "0.01}, \"width\": 641}"),
                 "an object has the field \"width\" twice");
}

TEST(CameraJsonTest, NamesValuesOfTheWrongKind) {
  EXPECT_INVALID(ReadWith("640", "640.5"), "camera \"left\": width is 640.5; expected a whole");
  EXPECT_INVALID(ReadWith("640", "1e12"), "camera \"left\": width is 1000000000000.0; expected");
  EXPECT_INVALID(ReadWith("640", "20000"), "camera \"left\": width is 20000; expected 1 to 16384");
  EXPECT_INVALID(ReadWith("0.1, -0.2, 3", "0.1, -0.2"), "camera \"left\": t is an array of 2");
  EXPECT_INVALID(ReadWith("0.1, -0.2, 3", "0.1, null, 3"), "camera \"left\": t[1] is null");
  EXPECT_INVALID(ReadWith("[0, -1, 0]", "[0, 1, 0]"), "camera \"left\": R is no rotation");
  EXPECT_INVALID(ReadWith("\"left\"", "17"), "camera 0 (from 0): name is 17; expected a string");
  EXPECT_INVALID(ReadWith("{\"k1\": -0.28", "3}, {\"k1\": -0.28"), "expected");
  EXPECT_INVALID(ReadWith("-0.28", "\"x\""), "camera \"left\", distortion: k1 is \"x\"");
  EXPECT_INVALID(ReadCamerasJson("{\"cameras\": []}"), "expected an array of cameras");
  EXPECT_INVALID(ReadCamerasJson("{\"cameras\": [4]}"),
                 "camera 0 (from 0) is 4; expected an object");
  EXPECT_INVALID(ReadCamerasJson("[]"), "no JSON object");
}

TEST(CameraJsonTest, RefusesTwoCamerasOfOneName) {
  EXPECT_INVALID(ReadWith("\"right\"", "\"left\""), "two cameras have the name \"left\"");
}

TEST(CameraJsonTest, SaysWhereTheJsonBreaks) {
  EXPECT_INVALID(ReadCamerasJson("{\n\"cameras\": [}"), "parse error at line 2, column 13");
  EXPECT_INVALID(ReadWith("640", "1e999"), "number overflow parsing '1e999'");
  EXPECT_INVALID(ReadCamerasJson(""), "unexpected end of input");
}

TEST(CameraJsonTest, WritesWhatItReadsToTheBit) {
  Camera camera;
  camera.name = "a \"b\" \xc3\xa9";
  camera.width = 1920;
  camera.height = 1080;
  camera.fx = 1000.0 / 3;
  camera.fy = 1e3 / 7;
  camera.cx = 0.1;
  camera.cy = -1e-7;
  camera.R = Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, -1).normalized()).toRotationMatrix();
  camera.t = Eigen::Vector3d(1e-9, -2.0 / 3, 12345.678);
  camera.distortion = {-0.28, 0.07, 2e-4, -5e-4, 0.01};
  Camera plain = camera;
  plain.name = "plain";
  plain.distortion = Distortion();
  const auto text = CamerasToJson({camera, plain});
  ASSERT_TRUE(text.ok()) << text.status();
  const auto read = ReadCamerasJson(*text);
  ASSERT_TRUE(read.ok()) << read.status();
  ASSERT_EQ(read->size(), 2u);
  EXPECT_EQ((*read)[0].name, camera.name);
  EXPECT_EQ((*read)[0].R, camera.R);
  EXPECT_EQ((*read)[0].t, camera.t);
  EXPECT_EQ((*read)[0].fx, camera.fx);
  EXPECT_EQ((*read)[0].fy, camera.fy);
  EXPECT_EQ((*read)[0].cx, camera.cx);
  EXPECT_EQ((*read)[0].cy, camera.cy);
  EXPECT_EQ((*read)[0].height, 1080);
  EXPECT_EQ((*read)[0].distortion.p2, -5e-4);
  EXPECT_EQ((*read)[0].distortion.k3, 0.01);
  EXPECT_TRUE((*read)[1].distortion.is_zero());
}

TEST(CameraJsonTest, RefusesToWriteWhatItWouldNotRead) {
  const std::vector<Camera> good = *ReadCamerasJson(kCamerasJson);
  const auto error = [&](auto change) {
    std::vector<Camera> cameras = good;
    change(&cameras);
    return CamerasToJson(cameras);
  };
  EXPECT_INVALID(error([](auto* c) { c->clear(); }), "no cameras");
  EXPECT_INVALID(error([](auto* c) { (*c)[1].name = "left"; }), "two cameras have the name");
  EXPECT_INVALID(error([](auto* c) { (*c)[1].fx = 0; }), "fx is 0");
  EXPECT_INVALID(error([](auto* c) { (*c)[1].name = "\xff"; }), "not UTF-8");
}

TEST(CameraJsonTest, SurvivesBrokenBytes) {
  const std::string good = kCamerasJson;
  testing::ForEachTruncation(
      good, [](const std::string& bytes) { EXPECT_INVALID(ReadCamerasJson(bytes), ""); });
  testing::ForEachFlip(good, 5000, 1, [](const std::string& bytes) {
    const auto cameras = ReadCamerasJson(bytes);
    EXPECT_TRUE(cameras.ok() || absl::IsInvalidArgument(cameras.status()));
  });
}

TEST(CameraJsonTest, SurvivesDeepNesting) {
  const int deep = 1'000'000;
  const std::string nested = std::string(deep, '[') + std::string(deep, ']');
  EXPECT_INVALID(ReadCamerasJson(std::string(deep, '[')), "parse error");
  EXPECT_INVALID(ReadCamerasJson(nested), "no JSON object");
  EXPECT_INVALID(ReadCamerasJson("{\"x\": " + nested + "}"), "an array of 1");
  EXPECT_INVALID(ReadWith("0.1, -0.2, 3", nested + ", 0, 0"), "t[0] is an array of 1");
}

}  // namespace
}  // namespace cagefit::client
