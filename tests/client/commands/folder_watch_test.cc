#include "client/commands/folder_watch.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace cagefit::client {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

// Files are written, and looks taken, at the times that a test says.
class FolderWatchTest : public ::testing::Test {
 protected:
  absl::Time At(double seconds) { return absl::FromUnixSeconds(1000) + absl::Seconds(seconds); }
  void Write(const std::string& name, int64_t bytes, double seconds) {
    files_[name] = {name, bytes, At(seconds)};
  }
  // What a look at that time makes available.
  std::vector<std::string> Look(double seconds) {
    std::vector<FileState> files;
    for (const auto& [name, file] : files_) files.push_back(file);
    watch_.Look(files, At(seconds));
    std::vector<std::string> taken;
    while (auto name = watch_.Take()) taken.push_back(*name);
    return taken;
  }

  std::map<std::string, FileState> files_;
  FolderWatch watch_{absl::Seconds(1)};
};

TEST_F(FolderWatchTest, AFileIsCompleteWhenItHasNotChangedForTheSettlingTime) {
  Write("0.ply", 10, 0);
  EXPECT_THAT(Look(0.1), IsEmpty());
  Write("0.ply", 20, 0.5);
  EXPECT_THAT(Look(0.6), IsEmpty());
  EXPECT_THAT(Look(1.5), IsEmpty());
  EXPECT_THAT(Look(1.6), ElementsAre("0.ply"));
  EXPECT_THAT(Look(9), IsEmpty()) << "once";
}

TEST_F(FolderWatchTest, AnotherTimeOfTheSameSizeIsAChange) {
  Write("0.ply", 10, 0);
  EXPECT_THAT(Look(0.9), IsEmpty());
  Write("0.ply", 10, 0.95);
  EXPECT_THAT(Look(1.1), IsEmpty());
  EXPECT_THAT(Look(2.1), ElementsAre("0.ply"));
}

TEST_F(FolderWatchTest, WhatWasThereBeforeIsCompleteAtOnceAndInNaturalOrder) {
  for (const char* name : {"f10.ply", "f9.ply", "f1.ply"}) Write(name, 10, -60);
  EXPECT_THAT(Look(0), ElementsAre("f1.ply", "f9.ply", "f10.ply"));
}

TEST_F(FolderWatchTest, ARenamedFileIsCompleteAtOnce) {
  Write("0.ply", 10, 0);
  watch_.Renamed("0.ply");
  EXPECT_THAT(Look(0.1), ElementsAre("0.ply"));
}

TEST_F(FolderWatchTest, ARenamedFileThatIsWrittenToIsNot) {
  Write("0.ply", 10, 0);
  Write("1.ply", 10, 0);
  watch_.Renamed("1.ply");
  EXPECT_THAT(Look(0.1), IsEmpty()) << "0.ply is first";
  Write("1.ply", 20, 0.9);
  EXPECT_THAT(Look(1.0), ElementsAre("0.ply"));
}

TEST_F(FolderWatchTest, AFileThatIsBeingWrittenHoldsThoseBehindItUp) {
  Write("0.ply", 10, 0);
  Write("1.ply", 10, 0);
  EXPECT_THAT(Look(0.1), IsEmpty());
  Write("0.ply", 20, 0.9);
  EXPECT_THAT(Look(1.2), IsEmpty());
  EXPECT_THAT(Look(2.2), ElementsAre("0.ply", "1.ply"));
}

TEST_F(FolderWatchTest, AnEmptyFileWaitsForALaterOne) {
  Write("0.ply", 0, 0);
  EXPECT_THAT(Look(60), IsEmpty());
  Write("1.ply", 10, 60);
  EXPECT_THAT(Look(60.5), IsEmpty());
  EXPECT_THAT(Look(61), ElementsAre("0.ply", "1.ply"));
}

TEST_F(FolderWatchTest, AFileThatComesAfterLaterOnesIsTooLate) {
  Write("1.ply", 10, -60);
  EXPECT_THAT(Look(0), ElementsAre("1.ply"));
  Write("0.ply", 10, 1);
  EXPECT_THAT(Look(5), IsEmpty());
  EXPECT_THAT(watch_.TakeLate(), ElementsAre("0.ply"));
  EXPECT_THAT(Look(6), IsEmpty());
  EXPECT_THAT(watch_.TakeLate(), IsEmpty());
}

TEST_F(FolderWatchTest, KnowsWhenSomethingChangedLast) {
  EXPECT_EQ(watch_.last_change(), absl::InfinitePast());
  Write("0.ply", 10, -60);
  Look(2);
  EXPECT_EQ(watch_.last_change(), At(2));
  Look(3);
  EXPECT_EQ(watch_.last_change(), At(2));
  Write("1.ply", 10, 3.5);
  Look(4);
  Write("1.ply", 20, 4.5);
  Look(5);
  EXPECT_EQ(watch_.last_change(), At(5));
}

}  // namespace
}  // namespace cagefit::client
