// What template_maker.h promises, on shapes made here and on every model and scan that there is.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include "client/io/geometry_file.h"
#include "core/base/random.h"
#include "core/cloud/normals.h"
#include "core/mesh/triangle_quality.h"
#include "core/template/mesh_repair.h"
#include "core/template/template_maker.h"
#include "tests/support/data.h"
#include "tests/support/shapes.h"

namespace cagefit {
namespace {

// Boundaries that need many of the control vertices leave no choice of valences; others do.
constexpr double kLeastRegular = 0.9, kLeastRegularAtBoundaries = 0.6;
constexpr int kVerticesPerLoop = 100;  // from which boundaries are easy
constexpr double kLeastQuality = 0.1;

absl::StatusOr<ControlMesh> FromGeometry(const client::Geometry& geometry, int32_t vertices,
                                         TemplateReport* report) {
  if (!geometry.is_cloud()) return TemplateFromMesh(geometry.mesh, {vertices, {}}, report);
  PointCloud cloud = ToCloud(geometry);
  if (!cloud.has_normals()) {
    const absl::Status status = EstimateNormals({}, &cloud);
    if (!status.ok()) return status;
  }
  return TemplateFromCloud(cloud, {vertices, {}}, report);
}

// Control meshes are manifold by construction (ControlMesh::Create).
void ExpectContract(const ControlMesh& cage, int32_t vertices, const TemplateReport& report) {
  EXPECT_NEAR(cage.vertex_count(), vertices, 0.01 * vertices);
  const Topology& topology = cage.topology();
  int regular = 0;
  for (int32_t v = 0; v < cage.vertex_count(); ++v) {
    const int valence = topology.Valence(v);
    const bool boundary = topology.IsBoundaryVertex(v);
    EXPECT_GE(valence, boundary ? 2 : 3);
    regular += boundary ? valence >= 3 && valence <= 5 : valence >= 5 && valence <= 7;
  }
  const bool easy = report.boundary_loops * kVerticesPerLoop <= vertices;
  EXPECT_GE(regular, (easy ? kLeastRegular : kLeastRegularAtBoundaries) * cage.vertex_count());
  for (int32_t f = 0; f < topology.triangle_count(); ++f) {
    const auto t = topology.triangles().col(f);
    EXPECT_GE(TriangleQuality(cage.vertices().col(t[0]), cage.vertices().col(t[1]),
                              cage.vertices().col(t[2])),
              kLeastQuality);
  }
  std::vector<int32_t> ignored;
  EXPECT_EQ(topology.Components(&ignored), report.components_kept);
}

TEST(TemplateContractTest, HoldsForMeshes) {
  TriangleMesh small = testing::Icosphere(3, 0.3), tiny = testing::Icosphere(3, 0.01);
  small.vertices.colwise() += Eigen::Vector3d(2, 0, 0);
  tiny.vertices.colwise() += Eigen::Vector3d(0, 2, 0);
  const TriangleMesh parts =
      testing::Together(testing::Together(testing::Icosphere(4), small), tiny);
  struct Case {
    const char* name;
    TriangleMesh mesh;
    int loops, kept, dropped;
    bool creases;
  };
  const Case cases[] = {{"open tube", testing::Tube(60, 40), 2, 1, 0, false},
                        {"sheet", testing::OpenGrid(30), 1, 1, 0, false},
                        {"parts of several sizes", parts, 0, 2, 1, false},
                        {"torus", testing::Torus(60, 24), 0, 1, 0, false},
                        {"hubs", testing::TouchingHubs(), 0, 1, 0, false},
                        {"cube", testing::Cube(12), 0, 1, 0, true},
                        {"coarse cube", testing::Cube(1), 0, 1, 0, true},
                        {"drum", testing::Drum(10), 0, 1, 0, true}};
  for (const Case& c : cases) {
    SCOPED_TRACE(c.name);
    TemplateReport report;
    const auto cage = TemplateFromMesh(c.mesh, {400, {}}, &report);
    ASSERT_TRUE(cage.ok()) << cage.status();
    ExpectContract(*cage, 400, report);
    EXPECT_EQ(report.boundary_loops, c.loops);
    EXPECT_EQ(report.components_kept, c.kept);
    EXPECT_EQ(report.components_dropped, c.dropped);
    EXPECT_EQ(report.crease_edges > 0, c.creases);
  }
}

// A drum whose barrel and lids are as few long thin triangles as a CAD program would write.
TEST(TemplateContractTest, HoldsForThinTrianglesOfParts) {
  constexpr int kAround = 64;
  TriangleMesh drum;
  drum.vertices.resize(3, 2 * kAround);
  drum.triangles.resize(3, 4 * kAround - 4);
  int64_t f = 0;
  for (int k = 0; k < kAround; ++k) {
    const double angle = 2 * M_PI * k / kAround;
    drum.vertices.col(k) << std::cos(angle), std::sin(angle), 0;
    drum.vertices.col(kAround + k) << std::cos(angle), std::sin(angle), 3;
    const int next = (k + 1) % kAround;
    drum.triangles.col(f++) << k, next, kAround + next;
    drum.triangles.col(f++) << k, kAround + next, kAround + k;
    if (k == 0 || next == 0) continue;
    drum.triangles.col(f++) << 0, next, k;  // lids: fans about one vertex of the rim
    drum.triangles.col(f++) << kAround, kAround + k, kAround + next;
  }
  for (const int32_t vertices : {200, 1000}) {
    TemplateReport report;
    const auto cage = TemplateFromMesh(drum, {vertices, {}}, &report);
    ASSERT_TRUE(cage.ok()) << cage.status();
    ExpectContract(*cage, vertices, report);
    EXPECT_GT(report.crease_edges, 20);
  }
}

// Vertices doubled, at the same place and unused, triangles without area, and a third one at an
// edge.
TEST(TemplateContractTest, HoldsForMeshesThatNeedRepair) {
  const TriangleMesh sphere = testing::Icosphere(4);
  TriangleMesh mesh;
  const int64_t n = 3 * sphere.triangles.cols();
  mesh.vertices.resize(3, n + 2);
  mesh.triangles.resize(3, sphere.triangles.cols() + 3);
  for (int64_t k = 0; k < n; ++k) {
    mesh.vertices.col(k) = sphere.vertices.col(sphere.triangles(k % 3, k / 3));
    mesh.triangles(k % 3, k / 3) = static_cast<int32_t>(k);
  }
  mesh.vertices.col(n) << 0, 0, 3;      // a fin's
  mesh.vertices.col(n + 1) << 9, 9, 9;  // unused
  mesh.triangles.col(sphere.triangles.cols()) << 0, 1, static_cast<int32_t>(n);
  mesh.triangles.col(sphere.triangles.cols() + 1) << 0, 0, 1;
  mesh.triangles.col(sphere.triangles.cols() + 2) = mesh.triangles.col(7);
  TemplateReport report;
  const auto cage = TemplateFromMesh(mesh, {300, {}}, &report);
  ASSERT_TRUE(cage.ok()) << cage.status();
  ExpectContract(*cage, 300, report);
  EXPECT_EQ(report.boundary_loops, 0);
  EXPECT_EQ(report.repaired_triangles, 3);
}

TEST(TemplateContractTest, HoldsForClouds) {
  PointCloud bare = CloudFromMesh(testing::Torus(160, 60));
  bare.normals.resize(3, 0);
  ASSERT_TRUE(EstimateNormals({}, &bare).ok());
  PointCloud noisy = CloudFromMesh(testing::Icosphere(5));
  Random random(3);
  for (int64_t i = 0; i < noisy.size(); ++i) {
    // A tenth of the points somewhere around.
    const Eigen::Vector3d to =
        i % 10 == 0 ? (3 * random.NormalVector()).eval() : (0.005 * random.NormalVector()).eval();
    noisy.points.col(i) += to.cast<float>();
  }
  TriangleMesh other = testing::Icosphere(4, 0.5);
  other.vertices.colwise() += Eigen::Vector3d(2, 0, 0);
  struct Case {
    const char* name;
    PointCloud cloud;
    int loops, parts;
  };
  const Case cases[] = {
      {"without normals", bare, 0, 1},
      {"with outliers", noisy, 0, 1},
      {"open", CloudFromMesh(testing::Tube(160, 130)), 2, 1},
      {"two parts", CloudFromMesh(testing::Together(testing::Icosphere(5), other)), 0, 2}};
  for (const Case& c : cases) {
    SCOPED_TRACE(c.name);
    TemplateReport report;
    const auto cage = TemplateFromCloud(c.cloud, {300, {}}, &report);
    ASSERT_TRUE(cage.ok()) << cage.status();
    ExpectContract(*cage, 300, report);
    EXPECT_EQ(report.boundary_loops, c.loops);
    EXPECT_EQ(report.components_kept, c.parts);
  }
}

std::vector<std::string> FilesIn(const std::string& folder) {
  std::vector<std::string> files;
  for (const auto& entry : std::filesystem::directory_iterator(testing::DataDir() + "/" + folder)) {
    if (client::IsGeometryFile(entry.path().string())) files.push_back(entry.path().string());
  }
  std::sort(files.begin(), files.end());
  return files;
}

// Boundary loops of the repaired mesh.
int32_t Loops(const TriangleMesh& mesh) {
  RepairReport ignored;
  const TriangleMesh clean = MakeManifold(mesh, &ignored);
  const auto topology =
      Topology::Create(static_cast<int32_t>(clean.vertices.cols()), clean.triangles);
  return topology.ok() ? static_cast<int32_t>(topology->BoundaryLoops().size()) : 0;
}

TEST(TemplateContractTest, HoldsForEveryModelThatThereIs) {
  CAGEFIT_NEEDS_DATA();
  for (const std::string& file : FilesIn("static")) {
    SCOPED_TRACE(file);
    const auto geometry = client::ReadGeometry(file);
    ASSERT_TRUE(geometry.ok()) << geometry.status();
    const int32_t vertices = std::max(800, 12 * Loops(geometry->mesh));
    TemplateReport report;
    const auto cage = FromGeometry(*geometry, vertices, &report);
    ASSERT_TRUE(cage.ok()) << cage.status();
    ExpectContract(*cage, vertices, report);
    EXPECT_EQ(report.boundary_loops, Loops(geometry->mesh));
    if (file.find("fandisk") != std::string::npos) {
      EXPECT_GT(report.crease_edges, 200);
      EXPECT_GE(report.corners, 20);
    }
  }
}

TEST(TemplateContractTest, HoldsForEveryScanThatThereIs) {
  CAGEFIT_NEEDS_DATA();
  for (const std::string& file : FilesIn("scans")) {
    SCOPED_TRACE(file);
    const auto geometry = client::ReadGeometry(file);
    ASSERT_TRUE(geometry.ok()) << geometry.status();
    TemplateReport report;
    const auto cage = FromGeometry(*geometry, 500, &report);
    ASSERT_TRUE(cage.ok()) << cage.status();
    ExpectContract(*cage, 500, report);
  }
}

}  // namespace
}  // namespace cagefit
