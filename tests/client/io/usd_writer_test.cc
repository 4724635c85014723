#include "client/io/usd_writer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <regex>

#include "client/io/file_bytes.h"
#include "tests/support/temp_folder.h"

namespace cagefit::client {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

// Reads back what stands in the brackets behind `what`: all of its numbers.
std::vector<double> NumbersBehind(const std::string& text, const std::string& what) {
  const size_t begin = text.find(what);
  EXPECT_NE(begin, std::string::npos) << what;
  if (begin == std::string::npos) return {};
  const size_t open = text.find('[', begin + what.size()), close = text.find(']', open);
  const std::string list = text.substr(open, close - open);
  std::vector<double> numbers;
  const std::regex number("-?[0-9.]+(e[-+]?[0-9]+)?");
  for (auto at = std::sregex_iterator(list.begin(), list.end(), number);
       at != std::sregex_iterator(); ++at) {
    numbers.push_back(std::stod(at->str()));
  }
  return numbers;
}

class UsdWriterTest : public ::testing::Test {
 protected:
  // Two triangles over the edge from 0 to 2, which is a crease.
  static ControlMesh Sheet() {
    Points3d V(3, 4);
    V << 0, 1, 1, 0,  //
        0, 0, 1, 1,   //
        0, 0, 0, 0.125;
    Triangles F(3, 2);
    F << 0, 0,  //
        1, 2,   //
        2, 3;
    return ControlMesh::Create(V, F, {{{0, 2}}, {1, 3}}).value();
  }
  static std::string Written(const MeshSequence& sequence, const SceneSettings& settings = {}) {
    const std::string path = cagefit::testing::TempFolder() + "sequence.usda";
    EXPECT_EQ(WriteUsd(path, sequence, settings), absl::OkStatus());
    return ReadFileBytes(path, 1 << 20).value();
  }
};

TEST_F(UsdWriterTest, WritesTheMeshItsCreasesAndItsMotion) {
  const ControlMesh sheet = Sheet();
  const Points3d later = (1.0 / 3 * sheet.vertices()).eval();
  const std::string text =
      Written({&sheet, {{4, &sheet.vertices()}, {7, &later}}}, SceneSettings{25, 0.01, 'Z'});
  EXPECT_EQ(text.substr(0, 10), "#usda 1.0\n");
  for (const char* line :
       {"defaultPrim = \"cagefit\"", "startTimeCode = 4", "endTimeCode = 7", "framesPerSecond = 25",
        "timeCodesPerSecond = 25", "metersPerUnit = 0.01", "upAxis = \"Z\"",
        "uniform token subdivisionScheme = \"loop\"", "token interpolateBoundary = \"edgeOnly\""}) {
    EXPECT_THAT(text, HasSubstr(line));
  }
  EXPECT_THAT(NumbersBehind(text, "faceVertexCounts"), ElementsAre(3, 3));
  EXPECT_THAT(NumbersBehind(text, "faceVertexIndices"), ElementsAre(0, 1, 2, 0, 2, 3));
  EXPECT_THAT(NumbersBehind(text, "creaseIndices"), ElementsAre(0, 2));
  EXPECT_THAT(NumbersBehind(text, "creaseLengths"), ElementsAre(2));
  EXPECT_THAT(NumbersBehind(text, "creaseSharpnesses"), ElementsAre(10));
  EXPECT_THAT(NumbersBehind(text, "cornerIndices"), ElementsAre(1, 3));
  EXPECT_THAT(NumbersBehind(text, "cornerSharpnesses"), ElementsAre(10, 10));
  EXPECT_THAT(NumbersBehind(text.substr(text.find("extent")), "4: "),
              ElementsAre(0, 0, 0, 1, 1, 0.125));
  const std::string points = text.substr(text.find("points.timeSamples"));
  EXPECT_THAT(NumbersBehind(points, "4: "), ElementsAre(0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0.125));
  const std::vector<double> moved = NumbersBehind(points, "7: ");
  ASSERT_EQ(moved.size(), static_cast<size_t>(later.size()));
  for (size_t k = 0; k < moved.size(); ++k) EXPECT_NEAR(moved[k], later.data()[k], 1e-7);
}

TEST_F(UsdWriterTest, AMeshWithoutTagsHasNone) {
  const ControlMesh cage = ControlMesh::Create(Sheet().vertices(), Sheet().triangles()).value();
  const std::string text = Written({&cage, {{0, &cage.vertices()}}});
  EXPECT_THAT(text, Not(HasSubstr("crease")));
  EXPECT_THAT(text, Not(HasSubstr("corner")));
}

TEST_F(UsdWriterTest, BracketsAreClosed) {
  const ControlMesh sheet = Sheet();
  const std::string text = Written({&sheet, {{0, &sheet.vertices()}}});
  for (const char* pair : {"()", "[]", "{}"}) {
    EXPECT_EQ(std::count(text.begin(), text.end(), pair[0]),
              std::count(text.begin(), text.end(), pair[1]));
  }
}

TEST_F(UsdWriterTest, RefusesASequenceWithoutFrames) {
  const ControlMesh sheet = Sheet();
  EXPECT_TRUE(absl::IsInvalidArgument(WriteUsd("/tmp/none.usda", {&sheet, {}}, {})));
}

}  // namespace
}  // namespace cagefit::client
