#include "client/commands/take_state.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "tests/support/temp_folder.h"

namespace cagefit::client {
namespace {

std::string Folder() {
  const std::string folder = cagefit::testing::TempFolder() + "take_state";
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
  return folder;
}

void Write(const std::string& path, const std::string& text) { std::ofstream(path) << text; }

TEST(TakeStateTest, ComesBackFromItsFile) {
  const std::string path = Folder() + "/take.json";
  EXPECT_FALSE(ReadTakeState(path).has_value());
  FitArguments arguments;
  arguments.options.mutable_fit()->set_arap_weight(0.1);
  TakeState state = {AskedOf(arguments, {}), "rig:50051", "0123", std::nullopt};
  ASSERT_TRUE(WriteTakeState(path, state).ok());
  auto read = ReadTakeState(path);
  ASSERT_TRUE(read.has_value());
  EXPECT_EQ(read->asked, state.asked);
  EXPECT_EQ(read->server, "rig:50051");
  EXPECT_EQ(read->session, "0123");
  EXPECT_FALSE(read->exit_code.has_value());
  state.exit_code = 4;
  ASSERT_TRUE(WriteTakeState(path, state).ok());
  EXPECT_EQ(ReadTakeState(path)->exit_code, 4);
}

TEST(TakeStateTest, ADamagedFileIsNone) {
  const std::string path = Folder() + "/take.json";
  for (const char* text : {"", "{", "[]", "7", "{\"asked\": {}}",
                           "{\"asked\": {}, \"server\": 1, \"session\": \"a\"}"}) {
    Write(path, text);
    EXPECT_FALSE(ReadTakeState(path).has_value()) << text;
  }
}

TEST(TakeStateTest, WhatIsAskedChangesWithSettingsAndFiles) {
  const std::string folder = Folder(), frame = folder + "/frame.ply", cage = folder + "/cage.obj";
  Write(frame, "one");
  Write(cage, "cage");
  FitArguments arguments;
  arguments.cage = cage;
  const Json asked = AskedOf(arguments, {frame});
  EXPECT_EQ(AskedOf(arguments, {frame}), asked);

  FitArguments other = arguments;
  other.options.mutable_fit()->set_max_iterations(7);
  EXPECT_NE(AskedOf(other, {frame}), asked);
  other = arguments;
  other.to_frame = 3;
  EXPECT_NE(AskedOf(other, {frame}), asked);
  EXPECT_NE(AskedOf(arguments, {frame, frame}), asked);

  Write(frame, "two and more");
  EXPECT_NE(AskedOf(arguments, {frame}), asked);
  Write(frame, "one");
  std::filesystem::last_write_time(frame,
                                   std::filesystem::file_time_type() + std::chrono::hours(1));
  const Json touched = AskedOf(arguments, {frame});
  EXPECT_NE(touched, asked);
  std::filesystem::last_write_time(cage, std::filesystem::file_time_type() + std::chrono::hours(1));
  EXPECT_NE(AskedOf(arguments, {frame}), touched);
}

TEST(TakeStateTest, ThreadsAndServersDoNotMatter) {
  FitArguments arguments;
  const Json asked = AskedOf(arguments, {});
  arguments.threads = 3;
  arguments.server = "elsewhere:1";
  arguments.json = true;
  EXPECT_EQ(AskedOf(arguments, {}), asked);
}

}  // namespace
}  // namespace cagefit::client
