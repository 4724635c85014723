#include "client/io/file_bytes.h"

#include <gmock/gmock.h>

#include <filesystem>

#include "tests/support/temp_folder.h"

namespace cagefit::client {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

std::string TempFile(const std::string& name) { return cagefit::testing::TempFolder() + name; }

TEST(FileBytesTest, WhatWasWrittenIsRead) {
  const std::string path = TempFile("file_bytes.bin");
  const std::string bytes("a\0b\n\xff", 5);
  ASSERT_TRUE(WriteFileBytes(path, bytes).ok());
  EXPECT_EQ(*ReadFileBytes(path, 5), bytes);
}

TEST(FileBytesTest, ErrorsNameThePath) {
  const auto missing = ReadFileBytes("/nowhere/x.ply", 10);
  EXPECT_EQ(missing.status().code(), absl::StatusCode::kNotFound);
  EXPECT_THAT(std::string(missing.status().message()), StartsWith("/nowhere/x.ply: "));
  EXPECT_EQ(ReadFileBytes(cagefit::testing::TempFolder(), 10).status().code(),
            absl::StatusCode::kInvalidArgument);
  const absl::Status written = WriteFileBytes("/nowhere/x.ply", "x");
  EXPECT_THAT(std::string(written.message()), StartsWith("/nowhere/x.ply: cannot be written"));
}

TEST(FileBytesTest, MakesAFolderWithThoseAboveIt) {
  const std::string folder = TempFile("file_bytes_made");
  std::filesystem::remove_all(folder);
  EXPECT_EQ(MakeFolder(folder + "/a/b"), absl::OkStatus());
  EXPECT_EQ(MakeFolder(folder + "/a/b"), absl::OkStatus()) << "it is there already";
  EXPECT_TRUE(std::filesystem::is_directory(folder + "/a/b"));
  ASSERT_TRUE(WriteFileBytes(folder + "/file", "x").ok());
  EXPECT_THAT(std::string(MakeFolder(folder + "/file/c").message()),
              StartsWith(folder + "/file/c: cannot be made"));
}

TEST(FileBytesTest, RefusesAFileAboveTheLimit) {
  const std::string path = TempFile("file_bytes_large.bin");
  ASSERT_TRUE(WriteFileBytes(path, "123456").ok());
  const auto bytes = ReadFileBytes(path, 5);
  EXPECT_EQ(bytes.status().code(), absl::StatusCode::kResourceExhausted);
  EXPECT_THAT(std::string(bytes.status().message()), HasSubstr("more than 5 bytes"));
}

TEST(FileBytesTest, ReadsWhatHasNoSize) {
  EXPECT_TRUE(ReadFileBytes("/dev/null", 10)->empty());
  EXPECT_EQ(ReadFileBytes("/dev/zero", 10).status().code(), absl::StatusCode::kResourceExhausted);
}

TEST(FileBytesTest, AFailedWriteLeavesTheOldFileAndNothingBeside) {
  const std::string folder = TempFile("file_bytes_folder");
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder + "/target");
  // A folder cannot be replaced by a file, so the last step fails.
  EXPECT_FALSE(WriteFileBytes(folder + "/target", "x").ok());
  const std::filesystem::directory_iterator entries(folder);
  EXPECT_EQ(std::distance(begin(entries), end(entries)), 1);
}

}  // namespace
}  // namespace cagefit::client
