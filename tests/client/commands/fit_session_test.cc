#include "client/commands/fit_session.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "tests/support/temp_folder.h"

namespace cagefit::client {
namespace {

using ::testing::HasSubstr;

TEST(FitSessionTest, FindsTheLastMeshBeforeAFrame) {
  const std::string out = cagefit::testing::TempFolder() + "fit_session_out";
  std::filesystem::remove_all(out);
  EXPECT_EQ(EarlierMesh(out, 10), "");
  std::filesystem::create_directories(out + "/frames");
  for (const char* name : {"0002", "0005"}) std::ofstream(out + "/frames/" + name + ".obj") << "x";
  EXPECT_EQ(EarlierMesh(out, 10), out + "/frames/0005.obj");
  EXPECT_EQ(EarlierMesh(out, 5), out + "/frames/0002.obj");
  EXPECT_EQ(EarlierMesh(out, 2), "");
  EXPECT_EQ(EarlierMesh(out, 0), "");
}

v1::SessionOptions InForce() {
  v1::SessionOptions options;
  options.mutable_fit()->set_arap_weight(0.01);
  options.mutable_fit()->set_max_iterations(50);
  options.set_key_interval(100);
  options.add_cameras()->set_name("left");
  return options;
}

TEST(FitSessionTest, OptionsThatTheSessionHasSoAreTheSame) {
  v1::SessionOptions asked;
  EXPECT_EQ(CheckSameOptions(asked, InForce()), absl::OkStatus());
  asked.mutable_fit()->set_arap_weight(0.01);
  asked.mutable_fit()->set_preset(v1::PRESET_PAPER);
  asked.set_tolerance(0.001);
  asked.add_cameras()->set_name("left");
  EXPECT_EQ(CheckSameOptions(asked, InForce()), absl::OkStatus());
}

TEST(FitSessionTest, AnotherOptionIsNamedWithBothValues) {
  v1::SessionOptions asked;
  asked.mutable_fit()->set_max_iterations(60);
  const absl::Status status = CheckSameOptions(asked, InForce());
  EXPECT_TRUE(absl::IsInvalidArgument(status)) << status;
  EXPECT_THAT(std::string(status.message()), HasSubstr("fit.max_iterations: 50 -> 60"));
  asked.Clear();
  asked.add_cameras()->set_name("right");
  EXPECT_THAT(std::string(CheckSameOptions(asked, InForce()).message()), HasSubstr("cameras"));
}

}  // namespace
}  // namespace cagefit::client
