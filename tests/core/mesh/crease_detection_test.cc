#include "core/mesh/crease_detection.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "core/base/random.h"
#include "tests/support/data.h"
#include "tests/support/mesh_file.h"
#include "tests/support/shapes.h"

namespace cagefit {
namespace {

CreaseTags Detect(const TriangleMesh& mesh, double angle = kDefaultCreaseAngle,
                  CreaseEffort effort = CreaseEffort::kOnParts) {
  const auto topology =
      Topology::Create(static_cast<int32_t>(mesh.vertices.cols()), mesh.triangles);
  EXPECT_TRUE(topology.ok()) << topology.status();
  return DetectCreases(mesh.vertices, *topology, angle, effort);
}

TEST(CreaseDetectionTest, ACubeHasItsTwelveEdgesAndEightCorners) {
  for (const int cells : {1, 2, 8}) {
    const TriangleMesh cube = testing::Cube(cells);
    const CreaseTags tags = Detect(cube);
    EXPECT_EQ(tags.edges.size(), 12u * cells);
    EXPECT_EQ(tags.corners.size(), 8u);
    for (const auto& [a, b] : tags.edges) {
      const Eigen::Vector3d middle = 0.5 * (cube.vertices.col(a) + cube.vertices.col(b));
      EXPECT_GE((middle.array() == 0 || middle.array() == 1).count(), 2) << middle.transpose();
    }
  }
}

TEST(CreaseDetectionTest, ARimIsACreaseWithoutCorners) {
  const TriangleMesh drum = testing::Drum(6);
  const CreaseTags tags = Detect(drum);
  EXPECT_EQ(tags.edges.size(), 2u * 36);
  EXPECT_TRUE(tags.corners.empty());
  for (const auto& [a, b] : tags.edges) {
    EXPECT_EQ(drum.vertices(2, a), drum.vertices(2, b));
    EXPECT_NEAR(drum.vertices.col(a).head<2>().norm(), 1, 1e-12);
  }
}

TEST(CreaseDetectionTest, RoundShapesHaveNoneHoweverCoarse) {
  for (const int levels : {0, 1, 3}) {
    EXPECT_TRUE(Detect(testing::Icosphere(levels)).edges.empty()) << levels;
  }
  EXPECT_TRUE(Detect(testing::Torus(12, 6)).edges.empty());
  EXPECT_TRUE(Detect(testing::Torus(80, 40)).edges.empty());
  EXPECT_TRUE(Detect(testing::OpenGrid(5)).edges.empty());
}

TEST(CreaseDetectionTest, NoiseHasNone) {
  TriangleMesh noisy = testing::Icosphere(4);  // edges of 0.07
  Random random(5);
  for (Eigen::Index v = 0; v < noisy.vertices.cols(); ++v) {
    noisy.vertices.col(v) += 0.02 * random.NormalVector();
  }
  EXPECT_TRUE(Detect(noisy).edges.empty());
}

// Two half planes that meet at x = 0 under an angle of 60 degrees at y = 0 and of 0 at y = 1.
TEST(CreaseDetectionTest, AFadingCreaseIsFollowedDownToAThirdOfTheAngle) {
  constexpr int kCells = 40;
  TriangleMesh sheet = testing::OpenGrid(kCells);
  for (Eigen::Index v = 0; v < sheet.vertices.cols(); ++v) {
    sheet.vertices(0, v) -= 0.5;
    const double half_angle = M_PI / 6 * (1 - sheet.vertices(1, v));
    sheet.vertices(2, v) = -std::abs(sheet.vertices(0, v)) * std::tan(half_angle);
  }
  const CreaseTags tags = Detect(sheet);
  double end = 0;
  for (const auto& [a, b] : tags.edges) {
    EXPECT_EQ(sheet.vertices(0, a), 0);
    EXPECT_EQ(sheet.vertices(0, b), 0);
    end = std::max({end, sheet.vertices(1, a), sheet.vertices(1, b)});
  }
  EXPECT_NEAR(end, 1 - (kDefaultCreaseAngle / 3) / 60, 2.0 / kCells);
  EXPECT_EQ(tags.edges.size(), static_cast<size_t>(std::lround(end * kCells)));
}

TEST(CreaseDetectionTest, TheAngleDecides) {
  const TriangleMesh cube = testing::Cube(4);
  EXPECT_TRUE(Detect(cube, 0).edges.empty());
  EXPECT_TRUE(Detect(cube, 91).edges.empty());
  EXPECT_EQ(Detect(cube, 89).edges.size(), 48u);
}

TEST(CreaseDetectionTest, ASetOfCreasesShorterThanATenthOfTheDiagonalIsLeftOut) {
  const TriangleMesh sphere = testing::Icosphere(3), cube = testing::Cube(2);
  for (const double side : {0.02, 0.04}) {  // beside a diagonal of 3.5: 12 sides are 0.24, 0.48
    TriangleMesh both = sphere;
    both.vertices.conservativeResize(3, sphere.vertices.cols() + cube.vertices.cols());
    both.vertices.rightCols(cube.vertices.cols()) = side * cube.vertices;
    both.triangles.conservativeResize(3, sphere.triangles.cols() + cube.triangles.cols());
    both.triangles.rightCols(cube.triangles.cols()) =
        cube.triangles.array() + static_cast<int32_t>(sphere.vertices.cols());
    EXPECT_EQ(Detect(both).edges.size(), side < 0.03 ? 0u : 24u) << side;
  }
}

TEST(CreaseDetectionTest, PartsHaveCreasesAndBodiesHaveNone) {
  CAGEFIT_NEEDS_DATA();
  for (const char* part : {"static/fandisk_6475.ply", "static/wingnut_3047.ply"}) {
    const CreaseTags tags = Detect(testing::ReadTestMesh(part));
    EXPECT_GT(tags.edges.size(), 380u) << part;
    // Thin triangles beside an edge, which have two sides as sharp, leave few loose ends.
    std::map<int32_t, int> degree;
    for (const auto& edge : tags.edges) ++degree[edge[0]], ++degree[edge[1]];
    EXPECT_LE(std::count_if(degree.begin(), degree.end(),
                            [](const auto& vertex) { return vertex.second == 1; }),
              8)
        << part;
  }
  for (const char* body :
       {"static/bunny_closed_34835.ply", "static/armadillo_49990.ply", "static/koala_49999.ply",
        "static/human_man_6890.ply", "static/spot_11533.ply", "static/spot_2930.ply",
        "static/fish_10786.ply", "static/face_25905.ply", "static/3holes_3596.ply",
        "static/plane_holes_8519.ply", "static/torus_2304.ply"}) {
    EXPECT_TRUE(Detect(testing::ReadTestMesh(body)).edges.empty()) << body;
  }
}

}  // namespace
}  // namespace cagefit
