#include "core/template/template_maker.h"

#include <gmock/gmock.h>

#include <Eigen/Geometry>

#include "core/cloud/normals.h"
#include "core/subdiv/limit.h"
#include "tests/support/data.h"
#include "tests/support/mesh_file.h"
#include "tests/support/shapes.h"

namespace cagefit {
namespace {

using ::testing::HasSubstr;

// A cloud of a tube's barrel: points of a fine mesh with its normals.
PointCloud TubeCloud() { return CloudFromMesh(testing::Tube(160, 130)); }

void ExpectSoundValences(const ControlMesh& cage) {
  for (int32_t v = 0; v < cage.vertex_count(); ++v) {
    EXPECT_GE(cage.topology().Valence(v), cage.topology().IsBoundaryVertex(v) ? 2 : 3);
  }
}

TEST(TemplateMakerTest, AMeshGivesTheCountAskedFor) {
  for (const int32_t count : {60, 314, 3000}) {
    TemplateReport report;
    const auto cage = TemplateFromMesh(testing::Icosphere(4), {count, {}}, &report);
    ASSERT_TRUE(cage.ok()) << cage.status();
    EXPECT_NEAR(cage->vertex_count(), count, 0.01 * count);
    EXPECT_EQ(report.boundary_loops, 0);
    EXPECT_EQ(report.components_kept, 1);
    ExpectSoundValences(*cage);
  }
}

TEST(TemplateMakerTest, TheLimitSurfaceLiesOnTheInput) {
  TemplateReport report;
  const auto cage = TemplateFromMesh(testing::Icosphere(4), {100, {}}, &report);
  ASSERT_TRUE(cage.ok()) << cage.status();
  Points3d limit;
  ApplyStencils(LimitPositionStencils(cage->topology(), cage->tags()), cage->vertices(), &limit);
  EXPECT_NEAR(limit.colwise().norm().mean(), 1, 0.01);
  EXPECT_GT(cage->vertices().colwise().norm().mean(), 1.02);  // as a control mesh has to
}

TEST(TemplateMakerTest, AnOpenCloudGivesAnOpenControlMesh) {
  TemplateReport report;
  const auto cage = TemplateFromCloud(TubeCloud(), {400, {}}, &report);
  ASSERT_TRUE(cage.ok()) << cage.status();
  EXPECT_NEAR(cage->vertex_count(), 400, 4);
  EXPECT_EQ(report.boundary_loops, 2);
  ExpectSoundValences(*cage);
}

TEST(TemplateMakerTest, ACloudWithoutNormalsWorksOnceTheyAreEstimated) {
  PointCloud cloud = CloudFromMesh(testing::Torus(160, 60));
  cloud.normals.resize(3, 0);
  TemplateReport report;
  EXPECT_FALSE(TemplateFromCloud(cloud, {200, {}}, &report).ok());
  ASSERT_TRUE(EstimateNormals({}, &cloud).ok());
  const auto cage = TemplateFromCloud(cloud, {200, {}}, &report);
  ASSERT_TRUE(cage.ok()) << cage.status();
  const Topology& topology = cage->topology();
  EXPECT_EQ(topology.vertex_count() - topology.edge_count() + topology.triangle_count(), 0);
}

TEST(TemplateMakerTest, SaysWhatFailed) {
  TemplateReport report;
  const TriangleMesh sphere = testing::Icosphere(3);
  EXPECT_THAT(std::string(TemplateFromMesh(sphere, {3, {}}, &report).status().message()),
              HasSubstr("vertices is 3; it must be from 4"));
  TriangleMesh flat = testing::OpenGrid(2);
  flat.vertices.setZero();
  EXPECT_EQ(TemplateFromMesh(flat, {4, {}}, &report).status().code(),
            absl::StatusCode::kFailedPrecondition);
  // A torus needs seven.
  EXPECT_THAT(
      std::string(TemplateFromMesh(testing::Torus(48, 24), {5, {}}, &report).status().message()),
      HasSubstr("the topology of the surface needs more"));
}

TEST(TemplateMakerTest, CreasesSurvive) {
  TemplateReport report;
  for (const int count : {100, 1000}) {  // fewer and more than the mesh has
    const auto cage = TemplateFromMesh(testing::Cube(8), {count, {}}, &report);
    ASSERT_TRUE(cage.ok()) << cage.status();
    EXPECT_EQ(cage->tags().corners.size(), 8u);
    EXPECT_EQ(report.corners, 8);
    EXPECT_EQ(report.crease_edges, static_cast<int32_t>(cage->tags().edges.size()));
    // The limit surface has the cube's edges: its corners, and its volume but for nothing.
    const LimitMesh limit = BuildLimitMesh(cage->topology(), cage->tags(), 2);
    Points3d V;
    ApplyStencils(limit.position, cage->vertices(), &V);
    double volume = 0;
    for (Eigen::Index f = 0; f < limit.triangles.cols(); ++f) {
      const auto t = limit.triangles.col(f);
      volume += V.col(t[0]).dot(V.col(t[1]).cross(V.col(t[2]))) / 6;
    }
    EXPECT_NEAR(volume, 1, 1e-3);
  }
}

TEST(TemplateMakerTest, CreasesAreGivenUpWhereTheyAskForTooMuchOrAreNotWanted) {
  TemplateReport report;
  const auto few = TemplateFromMesh(testing::Cube(8), {7, {}}, &report);
  ASSERT_TRUE(few.ok()) << few.status();
  EXPECT_TRUE(few->tags().edges.empty());
  const auto smooth = TemplateFromMesh(testing::Cube(8), {100, 0.0}, &report);
  ASSERT_TRUE(smooth.ok()) << smooth.status();
  EXPECT_TRUE(smooth->tags().edges.empty());
  EXPECT_THAT(
      std::string(TemplateFromMesh(testing::Cube(8), {100, 181.0}, &report).status().message()),
      HasSubstr("crease_angle is 181; it must be from 0 to 180"));
}

TEST(TemplateMakerTest, GivenTagsSurvive) {
  // A circle around a torus, which no angle would find, and a corner beside it.
  const TriangleMesh torus = testing::Torus(48, 24);
  TemplateOptions options;
  options.vertices = 200;
  for (int32_t k = 0; k < 48; ++k) options.tags.edges.push_back({k, (k + 1) % 48});
  options.tags.corners = {12 * 48 + 7};
  TemplateReport report;
  const auto cage = TemplateFromMesh(torus, options, &report);
  ASSERT_TRUE(cage.ok()) << cage.status();
  EXPECT_GE(report.crease_edges, 8);
  EXPECT_EQ(report.corners, 1);
  std::vector<int> degree(cage->vertex_count(), 0);
  for (const auto& edge : cage->tags().edges) {
    for (const int32_t v : edge) ++degree[v];
  }
  for (const int d : degree) EXPECT_TRUE(d == 0 || d == 2) << d;  // one closed curve
  options.tags.corners = {48 * 24};
  EXPECT_THAT(std::string(TemplateFromMesh(torus, options, &report).status().message()),
              HasSubstr("vertex 1152 is outside [0, 1152)"));
}

struct Real {
  const char* file;
  int32_t vertices;
  size_t loops;
};

TEST(TemplateMakerTest, RealMeshesKeepTheirBoundaries) {
  CAGEFIT_NEEDS_DATA();
  constexpr Real kReal[] = {
      {"static/bunny_closed_34835.ply", 314, 0}, {"static/bunny_closed_34835.ply", 4667, 0},
      {"static/bunny_35947.ply", 314, 5},        {"static/face_25905.ply", 1000, 1},
      {"static/plane_holes_8519.ply", 2000, 27}, {"static/torus_2304.ply", 200, 0}};
  for (const Real& real : kReal) {
    TemplateReport report;
    const auto cage =
        TemplateFromMesh(testing::ReadTestMesh(real.file), {real.vertices, {}}, &report);
    ASSERT_TRUE(cage.ok()) << real.file << ": " << cage.status();
    EXPECT_NEAR(cage->vertex_count(), real.vertices, 0.01 * real.vertices) << real.file;
    EXPECT_EQ(cage->topology().BoundaryLoops().size(), real.loops) << real.file;
    ExpectSoundValences(*cage);
  }
}

}  // namespace
}  // namespace cagefit
