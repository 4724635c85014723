#include "server/session/template_process.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <filesystem>
#include <fstream>

#include "absl/strings/str_cat.h"
#include "core/base/private_folder.h"
#include "tests/server/session/session_fixture.h"

namespace cagefit::server {
namespace {

using ::testing::HasSubstr;
using testing::ReasonOf;

const TemplateRequest kFour = {4, std::nullopt};

// As "cagefit template": $2 is the input, $4 the number of vertices, $6 the output.
constexpr char kWriteTetrahedron[] =
    "printf 'v 0 0 0\\nv 1 0 0\\nv 0 1 0\\nv 0 0 1\\n"
    "f 1 3 2\\nf 1 2 4\\nf 2 3 4\\nf 3 1 4\\n' > \"$6\"\n";

class TemplateProcessTest : public ::testing::Test {
 protected:
  // A maker whose program is this shell script.
  TemplateProcess Maker(const std::string& script, const ChildLimits& limits = {}) {
    const std::string path = folder_.path() + "/program";
    std::ofstream(path) << "#!/bin/sh\n" << script;
    EXPECT_EQ(chmod(path.c_str(), 0700), 0);
    return TemplateProcess(path, limits);
  }
  absl::Status ErrorOf(const std::string& script, const ChildLimits& limits = {}) {
    return Maker(script, limits).Make("bytes", kFour, nullptr).status();
  }
  std::string Path(const std::string& name) const { return folder_.path() + "/" + name; }

  PrivateFolder folder_ = PrivateFolder::Create().value();
};

TEST_F(TemplateProcessTest, ReadsTheMeshThatTheProgramWrites) {
  TemplateProcess maker = Maker(kWriteTetrahedron);
  EXPECT_EQ(maker.CheckAvailable(), absl::OkStatus());
  const auto mesh = maker.Make("bytes", kFour, nullptr);
  ASSERT_TRUE(mesh.ok()) << mesh.status();
  EXPECT_EQ(mesh->vertex_count(), 4);
}

TEST_F(TemplateProcessTest, GivesTheProgramTheBytesAndTheNumberOfVertices) {
  const std::string bytes("not\0text", 8);
  TemplateProcess maker = Maker(
      absl::StrCat("cp \"$2\" ", Path("input"), "\necho \"$1 $3 $4 $5\" > ", Path("arguments"),
                   "\necho \"$6\" > ", Path("output"), "\n", kWriteTetrahedron));
  ASSERT_TRUE(maker.Make(bytes, {1234, {}}, nullptr).ok());
  std::string line;
  std::getline(std::ifstream(Path("arguments")), line);
  EXPECT_EQ(line, "template --vertices 1234 --out");
  std::ifstream input(Path("input"), std::ios::binary);
  EXPECT_EQ(std::string(std::istreambuf_iterator<char>(input), {}), bytes);
  std::getline(std::ifstream(Path("output")), line);
  EXPECT_FALSE(std::filesystem::exists(std::filesystem::path(line).parent_path()))
      << "the folder is still there";
}

TEST_F(TemplateProcessTest, PassesACreaseAngleThatIsSet) {
  const auto arguments_after_the_output = [this](const TemplateRequest& request) {
    EXPECT_TRUE(Maker(absl::StrCat("shift 6; echo \"$@\" > ", Path("arguments"), "\n", "exit 1"))
                    .Make("bytes", request, nullptr)
                    .status()
                    .code() == absl::StatusCode::kInvalidArgument);
    std::string line;
    std::getline(std::ifstream(Path("arguments")), line);
    return line;
  };
  EXPECT_EQ(arguments_after_the_output(kFour), "");
  EXPECT_EQ(arguments_after_the_output({4, 37.5}), "--crease-angle 37.5");
  EXPECT_EQ(arguments_after_the_output({4, 0.0}), "--crease-angle 0");
}

TEST_F(TemplateProcessTest, AMissingProgramIsNamed) {
  TemplateProcess maker("/nowhere/cagefit", {});
  for (const absl::Status& status :
       {maker.CheckAvailable(), maker.Make("bytes", kFour, nullptr).status()}) {
    EXPECT_TRUE(absl::IsFailedPrecondition(status)) << status;
    EXPECT_THAT(std::string(status.message()), HasSubstr("/nowhere/cagefit"));
    EXPECT_EQ(ReasonOf(status), "TEMPLATE_PROGRAM_MISSING");
  }
}

TEST_F(TemplateProcessTest, AFrameThatGivesNoTemplateIsInvalid) {
  const absl::Status status = ErrorOf("echo 'too few points' >&2; exit 1");
  EXPECT_TRUE(absl::IsInvalidArgument(status)) << status;
  EXPECT_THAT(std::string(status.message()), HasSubstr("too few points"));
  EXPECT_EQ(ReasonOf(status), "TEMPLATE_FAILED");
}

TEST_F(TemplateProcessTest, AProgramWithoutTemplatesIsAFailedPrecondition) {
  for (const char* script : {"exit 2", "exit 126", "exit 127"}) {
    const absl::Status status = ErrorOf(script);
    EXPECT_TRUE(absl::IsFailedPrecondition(status)) << script << ": " << status;
  }
}

TEST_F(TemplateProcessTest, ACrashIsInternal) {
  for (const char* script : {"kill -SEGV $$", "exit 3"}) {
    const absl::Status status = ErrorOf(script);
    EXPECT_TRUE(absl::IsInternal(status)) << script << ": " << status;
    EXPECT_EQ(ReasonOf(status), "TEMPLATE_FAILED");
  }
}

TEST_F(TemplateProcessTest, AKilledProgramMetALimit) {
  const absl::Status status = ErrorOf("kill -KILL $$");
  EXPECT_TRUE(absl::IsResourceExhausted(status)) << status;
}

TEST_F(TemplateProcessTest, OutputThatIsNoControlMeshIsInternal) {
  const std::string too_large =
      "for k in 1 2 3 4 5 6 7 8 9; do echo v $k 0 0; done > \"$6\"";  // where 4 were asked for
  for (const std::string& script :
       {std::string("exit 0"), std::string("echo garbage > \"$6\""), too_large}) {
    const absl::Status status = ErrorOf(script);
    EXPECT_TRUE(absl::IsInternal(status)) << script << ": " << status;
  }
}

TEST_F(TemplateProcessTest, StopsAtTheTimeLimit) {
  ChildLimits limits;
  limits.max_time = absl::Milliseconds(50);
  const absl::Status status = ErrorOf("sleep 1000", limits);
  EXPECT_TRUE(absl::IsResourceExhausted(status)) << status;
}

TEST_F(TemplateProcessTest, StopsWhenCancelled) {
  TemplateProcess maker = Maker("sleep 1000");
  EXPECT_TRUE(absl::IsCancelled(maker.Make("bytes", kFour, [] { return true; }).status()));
}

}  // namespace
}  // namespace cagefit::server
