// What other programs are given, opened by another reader: Open Asset Import Library; of USD, of
// which Debian has none, the text.
#include <assimp/scene.h>
#include <gmock/gmock.h>

#include <assimp/Importer.hpp>
#include <cmath>
#include <iterator>
#include <sstream>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "client/io/geometry_file.h"
#include "tests/e2e/program.h"

namespace cagefit::testing {
namespace {

using ::testing::HasSubstr;

constexpr int kFrames = 3;
const std::vector<std::string> kFormats = {
    "--format", "ply,usd,gltf",  "--fps", "30",        "--metres-per-unit",
    "0.01",     "--gltf-levels", "2",     "--up-axis", "Z"};

class FormatsTest : public ::testing::Test {
 protected:
  void SetUp() override {
    capture_ = EmptyFolder("capture");
    out_ = EmptyFolder("out");
    ASSERT_EQ(RunCagefit({"synth", "blob", "--out", capture_, "--frames", "3", "--points", "5000"})
                  .exit_code,
              0);
  }

  ProgramResult Fit(const std::vector<std::string>& more) const {
    std::vector<std::string> arguments = {"fit",        capture_, "--out",  out_,
                                          "--vertices", "150",    "--quick"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    arguments.insert(arguments.end(), kFormats.begin(), kFormats.end());
    return RunCagefit(arguments);
  }

  ControlMesh Cage(int k) const {
    return client::ReadControlMesh(absl::StrCat(out_, "/frames/000", k, ".obj")).value();
  }

  std::string capture_, out_;
};

// Triangle by triangle, as readers may number vertices anew; `at` is where the reader has them.
double LargestDistance(const aiMesh& mesh, const aiVector3D* at, const TriangleMesh& expected) {
  if (mesh.mNumFaces != expected.triangles.cols()) return 1e300;
  double worst = 0;
  for (unsigned f = 0; f < mesh.mNumFaces; ++f) {
    for (int c = 0; c < 3; ++c) {
      const aiVector3D& p = at[mesh.mFaces[f].mIndices[c]];
      const Eigen::Vector3d point(p.x, p.y, p.z);
      const auto vertex = expected.vertices.col(expected.triangles(c, f));
      worst = std::max(worst, (point - vertex).norm());
    }
  }
  return worst;
}

const aiMesh& OnlyMesh(Assimp::Importer* importer, const std::string& path) {
  static const aiMesh none;
  const aiScene* scene = importer->ReadFile(path, 0);
  EXPECT_NE(scene, nullptr) << path << ": " << importer->GetErrorString();
  return scene == nullptr || scene->mNumMeshes != 1 ? none : *scene->mMeshes[0];
}

// The points of a .usda file at a time code.
std::vector<double> UsdPoints(const std::string& text, int time) {
  const size_t points = text.find("points.timeSamples");
  const size_t begin = text.find(absl::StrCat(" ", time, ": [("), points);
  std::string list = text.substr(begin, text.find(']', begin) - begin);
  list.erase(0, list.find('['));
  for (char& c : list) {
    if (std::string("[](),").find(c) != std::string::npos) c = ' ';
  }
  std::istringstream numbers(list);
  return {std::istream_iterator<double>(numbers), {}};
}

TEST_F(FormatsTest, EveryFrameOfEveryFormatIsTheFittedOne) {
  const ProgramResult fit = Fit({});
  ASSERT_EQ(fit.exit_code, 0) << fit.err;
  const std::string usd = ReadText(out_ + "/sequence.usda");
  for (const char* line : {"framesPerSecond = 30", "metersPerUnit = 0.01", "upAxis = \"Z\"",
                           "startTimeCode = 0", "endTimeCode = 2"}) {
    EXPECT_THAT(usd, HasSubstr(line));
  }
  Assimp::Importer glb_importer;
  const aiMesh& glb = OnlyMesh(&glb_importer, out_ + "/sequence.glb");
  ASSERT_EQ(glb.mNumAnimMeshes, kFrames - 1u);
  for (int k = 0; k < kFrames; ++k) {
    SCOPED_TRACE(k);
    const ControlMesh cage = Cage(k);
    const TriangleMesh mesh = {cage.vertices(), cage.triangles()};
    for (const char* ending : {".obj", ".ply"}) {
      Assimp::Importer importer;
      const aiMesh& read = OnlyMesh(&importer, absl::StrCat(out_, "/frames/000", k, ending));
      EXPECT_LT(LargestDistance(read, read.mVertices, mesh), 1e-6) << ending;
    }
    const std::vector<double> points = UsdPoints(usd, k);
    ASSERT_EQ(points.size(), static_cast<size_t>(cage.vertices().size()));
    for (size_t i = 0; i < points.size(); ++i) {
      ASSERT_NEAR(points[i], cage.vertices().data()[i], 1e-6) << i;
    }
    // Of glTF, the surface: what `refine` makes of the frame.
    const std::string fine = absl::StrCat(out_, "/fine", k, ".ply");
    ASSERT_EQ(RunCagefit({"refine", absl::StrCat(out_, "/frames/000", k, ".obj"), "--levels", "2",
                          "--out", fine})
                  .exit_code,
              0);
    const aiVector3D* at = k == 0 ? glb.mVertices : glb.mAnimMeshes[k - 1]->mVertices;
    EXPECT_LT(LargestDistance(glb, at, client::ReadGeometry(fine)->mesh), 1e-6);
  }
}

TEST_F(FormatsTest, ASessionIsPulledInTheSameFormatsToTheByte) {
  ServerProgram server;
  const ProgramResult fit = Fit({"--server", server.address(), "--keep-session"});
  ASSERT_EQ(fit.exit_code, 0) << fit.err;
  const std::string id = ReadJson(out_ + "/report.json")["session"]["session_id"];
  const std::string pulled = EmptyFolder("pulled");
  std::vector<std::string> arguments = {"session",  "pull",          id, "--frames", pulled,
                                        "--server", server.address()};
  arguments.insert(arguments.end(), kFormats.begin(), kFormats.end());
  const ProgramResult pull = RunCagefit(arguments);
  ASSERT_EQ(pull.exit_code, 0) << pull.err;
  for (const char* file : {"/sequence.usda", "/sequence.glb"}) {
    EXPECT_EQ(ReadText(pulled + file), ReadText(out_ + file)) << file;
  }
  EXPECT_EQ(ReadText(pulled + "/0002.ply"), ReadText(out_ + "/frames/0002.ply"));
}

TEST_F(FormatsTest, RefinedMeshesHaveTheNormalsOfTheirSurface) {
  ASSERT_EQ(Fit({}).exit_code, 0);
  for (const char* ending : {".obj", ".ply"}) {
    const std::string fine = out_ + "/fine" + ending;
    ASSERT_EQ(RunCagefit({"refine", out_ + "/cage.obj", "--levels", "3", "--out", fine}).exit_code,
              0);
    Assimp::Importer importer;
    const aiMesh& mesh = OnlyMesh(&importer, fine);
    ASSERT_TRUE(mesh.HasNormals());
    for (unsigned f = 0; f < mesh.mNumFaces; ++f) {
      const unsigned* v = mesh.mFaces[f].mIndices;
      const aiVector3D face = (mesh.mVertices[v[1]] - mesh.mVertices[v[0]]) ^
                              (mesh.mVertices[v[2]] - mesh.mVertices[v[0]]);
      for (int c = 0; c < 3; ++c) {
        const aiVector3D& normal = mesh.mNormals[v[c]];
        ASSERT_NEAR(normal.Length(), 1, 1e-5);
        ASSERT_GT(normal * face, 0.9 * face.Length()) << ending << ": " << f;
      }
    }
  }
}

TEST_F(FormatsTest, AFormatThatThereIsNotIsWrongUsage) {
  EXPECT_EQ(RunCagefit({"fit", capture_, "--out", out_, "--vertices", "150", "--format", "max"})
                .exit_code,
            2);
  EXPECT_EQ(RunCagefit({"fit", capture_, "--out", out_, "--vertices", "150", "--gltf-levels", "2"})
                .exit_code,
            2);
}

}  // namespace
}  // namespace cagefit::testing
