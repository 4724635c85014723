#include "core/cloud/normals.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include "tests/support/shapes.h"
#include "tests/support/spoiled_cloud.h"

namespace cagefit {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

// The vertices of a mesh in random order, so that neighbours are no neighbours in memory.
PointCloud Shuffled(const Points3d& points) {
  std::mt19937 random(3);
  std::vector<int64_t> order(points.cols());
  for (size_t i = 0; i < order.size(); ++i) order[i] = static_cast<int64_t>(i);
  std::shuffle(order.begin(), order.end(), random);
  PointCloud cloud;
  cloud.points.resize(3, points.cols());
  for (int64_t i = 0; i < points.cols(); ++i) {
    cloud.points.col(i) = points.col(order[i]).cast<float>();
  }
  return cloud;
}

// Smallest n . normal(p) over the cloud; `normal` is the exact outward one.
template <typename Normal>
double WorstAgreement(const PointCloud& cloud, const Normal& normal) {
  double worst = 1;
  for (int64_t i = 0; i < cloud.size(); ++i) {
    const Eigen::Vector3d p = cloud.points.col(i).cast<double>();
    worst = std::min(worst, cloud.normals.col(i).cast<double>().dot(normal(p)));
  }
  return worst;
}

Eigen::Vector3d SphereNormal(const Eigen::Vector3d& p) { return p.normalized(); }
Eigen::Vector3d TubeNormal(const Eigen::Vector3d& p) {
  return Eigen::Vector3d(p.x(), p.y(), 0).normalized();
}
Eigen::Vector3d TorusNormal(const Eigen::Vector3d& p) {
  return (p - Eigen::Vector3d(p.x(), p.y(), 0).normalized()).normalized();  // major radius 1
}

std::string ErrorOf(const NormalOptions& options, PointCloud cloud) {
  const absl::Status status = EstimateNormals(options, &cloud);
  if (status.ok()) return "accepted";
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  return std::string(status.message());
}

TEST(EstimateNormalsTest, AreUnitVectors) {
  PointCloud cloud = Shuffled(testing::Icosphere(4).vertices);
  ASSERT_TRUE(EstimateNormals({}, &cloud).ok());
  ASSERT_EQ(cloud.normals.cols(), cloud.size());
  EXPECT_LT((cloud.normals.colwise().norm().array() - 1).abs().maxCoeff(), 1e-5);
}

TEST(EstimateNormalsTest, PointOutOfASphere) {
  PointCloud cloud = Shuffled(testing::Icosphere(4).vertices);
  ASSERT_TRUE(EstimateNormals({}, &cloud).ok());
  EXPECT_GT(WorstAgreement(cloud, SphereNormal), 0.99);
}

TEST(EstimateNormalsTest, PointOutOfASphereFarFromTheOrigin) {
  PointCloud cloud = Shuffled(testing::Icosphere(4).vertices);
  const Eigen::Vector3f centre(-40, 25, -60);
  cloud.points.colwise() += centre;
  ASSERT_TRUE(EstimateNormals({}, &cloud).ok());
  cloud.points.colwise() -= centre;
  EXPECT_GT(WorstAgreement(cloud, SphereNormal), 0.99);
}

TEST(EstimateNormalsTest, PointOutOfATorus) {
  PointCloud cloud = Shuffled(testing::Torus(120, 40).vertices);
  ASSERT_TRUE(EstimateNormals({}, &cloud).ok());
  EXPECT_GT(WorstAgreement(cloud, TorusNormal), 0.97);
}

TEST(EstimateNormalsTest, PointOutOfATubeOpenAtBothEnds) {
  PointCloud cloud = Shuffled(testing::Tube(80, 25).vertices);
  ASSERT_TRUE(EstimateNormals({}, &cloud).ok());
  EXPECT_GT(WorstAgreement(cloud, TubeNormal), 0.98);
}

// It widens upwards, so that its topmost points face down: here only the flux can tell, and only
// about the cloud's own centre.
TEST(EstimateNormalsTest, PointOutOfAFunnelWhereverItIs) {
  Points3d points = testing::Tube(80, 25, 1, 1).vertices;
  for (int64_t i = 0; i < points.cols(); ++i) points.col(i).head<2>() *= 0.5 + 0.5 * points(2, i);
  for (const double height : {0.0, 60.0, -60.0}) {
    const Eigen::Vector3f at(-40, 25, static_cast<float>(height));
    PointCloud cloud = Shuffled(points);
    cloud.points.colwise() += at;
    ASSERT_TRUE(EstimateNormals({}, &cloud).ok());
    cloud.points.colwise() -= at;
    const auto normal = [](const Eigen::Vector3d& p) {
      return (TubeNormal(p) - 0.5 * Eigen::Vector3d::UnitZ()).normalized().eval();
    };
    EXPECT_GT(WorstAgreement(cloud, normal), 0.97) << "at height " << height;
  }
}

// Signs travel where neighbours agree: from side to side through the blended normals at an edge,
// not straight across it, where outward normals are 120 degrees apart and would be made to agree.
TEST(EstimateNormalsTest, PointOutOfAThreeSidedPrism) {
  constexpr int kAcross = 40, kAlong = 60;
  Points3d points(3, 3 * kAcross * kAlong);
  for (int i = 0; i < points.cols(); ++i) {
    const double along_side = 2 * std::sqrt(3.0) * ((i / 3 % kAcross + 0.5) / kAcross - 0.5);
    const double angle = 2 * M_PI / 3 * (i % 3);
    points.col(i) << std::cos(angle) - along_side * std::sin(angle),
        std::sin(angle) + along_side * std::cos(angle), 0.08 * (i / (3 * kAcross));
  }
  PointCloud cloud = Shuffled(points);
  ASSERT_TRUE(EstimateNormals({}, &cloud).ok());
  const auto normal = [](const Eigen::Vector3d& p) {
    const double side = 2 * M_PI / 3 * std::round(std::atan2(p.y(), p.x()) / (2 * M_PI / 3));
    return Eigen::Vector3d(std::cos(side), std::sin(side), 0);
  };
  EXPECT_GT(WorstAgreement(cloud, normal), 0.2);
}

TEST(EstimateNormalsTest, PointOutOfEachOfTwoSpheres) {
  const Points3d sphere = testing::Icosphere(4).vertices;
  Points3d both(3, 2 * sphere.cols());
  both << (0.5 * sphere).colwise() - Eigen::Vector3d(4, 0, 0),
      sphere.colwise() + Eigen::Vector3d(4, 0, 0);
  PointCloud cloud = Shuffled(both);
  ASSERT_TRUE(EstimateNormals({}, &cloud).ok());
  const auto normal = [](const Eigen::Vector3d& p) {
    return (p - Eigen::Vector3d(p.x() < 0 ? -4 : 4, 0, 0)).normalized().eval();
  };
  EXPECT_GT(WorstAgreement(cloud, normal), 0.99);
}

// So many that the signs of the eigenvectors cannot all happen to be right.
TEST(EstimateNormalsTest, PointOutOfEachOfManySpheres) {
  const Points3d sphere = testing::Icosphere(2).vertices;
  const int64_t size = sphere.cols();
  Points3d all(3, 27 * size);
  for (int64_t k = 0; k < 27; ++k) {
    const Eigen::Vector3d centre = 4 * Eigen::Vector3d(k % 3, k / 3 % 3, k / 9);
    all.middleCols(k * size, size) = sphere.colwise() + centre;
  }
  PointCloud cloud = Shuffled(all);
  ASSERT_TRUE(EstimateNormals({}, &cloud).ok());
  const auto normal = [](const Eigen::Vector3d& p) {
    return (p - 4 * (p / 4).array().round().matrix()).normalized().eval();
  };
  EXPECT_GT(WorstAgreement(cloud, normal), 0.95);
}

TEST(EstimateNormalsTest, OfAnOpenSheetAgreeAndPointUp) {
  // A wave over the unit square encloses nothing: its topmost point decides.
  Points3d points = testing::OpenGrid(40).vertices;
  for (int64_t i = 0; i < points.cols(); ++i) points(2, i) = 0.1 * std::sin(8 * points(0, i));
  PointCloud cloud = Shuffled(points);
  ASSERT_TRUE(EstimateNormals({}, &cloud).ok());
  const auto normal = [](const Eigen::Vector3d& p) {
    return Eigen::Vector3d(-0.8 * std::cos(8 * p.x()), 0, 1).normalized();
  };
  EXPECT_GT(WorstAgreement(cloud, normal), 0.95);
}

TEST(EstimateNormalsTest, OfAPlaneAreExact) {
  PointCloud cloud = Shuffled(testing::OpenGrid(20).vertices);
  ASSERT_TRUE(EstimateNormals({}, &cloud).ok());
  EXPECT_GT(WorstAgreement(cloud, [](const auto&) { return Eigen::Vector3d::UnitZ().eval(); }),
            1 - 1e-6);
}

TEST(EstimateNormalsTest, PointTowardsASensorInsideASphere) {
  PointCloud cloud = Shuffled(testing::Icosphere(4).vertices);
  NormalOptions options;
  options.sensor = Eigen::Vector3d(0.1, -0.2, 0.05);
  ASSERT_TRUE(EstimateNormals(options, &cloud).ok());
  EXPECT_GT(WorstAgreement(cloud, [](const auto& p) { return (-SphereNormal(p)).eval(); }), 0.99);
}

TEST(EstimateNormalsTest, PointTowardsASensorAboveOrBelowAPlane) {
  for (const double height : {3.0, -3.0}) {
    PointCloud cloud = Shuffled(testing::OpenGrid(20).vertices);
    NormalOptions options;
    options.sensor = Eigen::Vector3d(0.5, 0.5, height);
    ASSERT_TRUE(EstimateNormals(options, &cloud).ok());
    const double side = height > 0 ? 1 : -1;
    EXPECT_GT(WorstAgreement(cloud,
                             [&](const auto&) { return (side * Eigen::Vector3d::UnitZ()).eval(); }),
              0.999);
  }
}

TEST(EstimateNormalsTest, ReplaceNormalsThatWereThere) {
  PointCloud cloud = Shuffled(testing::Icosphere(4).vertices);
  cloud.normals = -cloud.points;
  ASSERT_TRUE(EstimateNormals({}, &cloud).ok());
  EXPECT_GT(WorstAgreement(cloud, SphereNormal), 0.99);
}

TEST(EstimateNormalsTest, WorkWithTheFewestAndTheMostNeighbours) {
  for (const int neighbors : {3, 100}) {
    PointCloud cloud = Shuffled(testing::Icosphere(5).vertices);
    NormalOptions options;
    options.neighbors = neighbors;
    ASSERT_TRUE(EstimateNormals(options, &cloud).ok());
    EXPECT_EQ(cloud.normals.cols(), cloud.size());
    EXPECT_TRUE(cloud.normals.allFinite());
  }
}

// Mean angle to the sphere's normals in rad, of a sphere with noise of a share of its diagonal.
double MeanAngleUnderNoise(double share) {
  PointCloud cloud = testing::WithNoise(Shuffled(testing::Icosphere(6).vertices), share);
  EXPECT_TRUE(EstimateNormals({}, &cloud).ok());
  double sum = 0;
  for (int64_t i = 0; i < cloud.size(); ++i) {
    const Eigen::Vector3d n = cloud.normals.col(i).cast<double>();
    const double cosine = n.dot(SphereNormal(cloud.points.col(i).cast<double>()));
    sum += std::acos(std::clamp(cosine, -1.0, 1.0));
  }
  return sum / static_cast<double>(cloud.size());
}

// 16 neighbours see noise alone at 1 %: the mean angle is then 0.8.
TEST(EstimateNormalsTest, SeeThroughNoiseOfSeveralSpacings) {
  EXPECT_LT(MeanAngleUnderNoise(0.003), 0.1);
  EXPECT_LT(MeanAngleUnderNoise(0.01), 0.08);
}

TEST(EstimateNormalsErrorTest, NamesTheNumberOfNeighbours) {
  const PointCloud cloud = Shuffled(testing::Icosphere(3).vertices);
  for (const int neighbors : {2, -1, 101}) {
    NormalOptions options;
    options.neighbors = neighbors;
    EXPECT_THAT(ErrorOf(options, cloud), HasSubstr("neighbors is " + std::to_string(neighbors)));
  }
}

TEST(EstimateNormalsErrorTest, NamesTheNumberOfTooFewPoints) {
  const PointCloud cloud = Shuffled(testing::Icosphere(0).vertices);
  EXPECT_THAT(ErrorOf({}, cloud), AllOf(HasSubstr("points: 12"), HasSubstr("16 neighbours")));
}

TEST(EstimateNormalsErrorTest, AcceptsAsManyPointsAsNeighbours) {
  const PointCloud cloud = Shuffled(testing::Icosphere(0).vertices);
  NormalOptions options;
  options.neighbors = 12;
  EXPECT_EQ(ErrorOf(options, cloud), "accepted");
}

}  // namespace
}  // namespace cagefit
