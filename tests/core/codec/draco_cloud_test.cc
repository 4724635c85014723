#include <draco/compression/expert_encode.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <random>
#include <vector>

#include "core/codec/draco_codec.h"
#include "tests/core/codec/draco_samples.h"

namespace cagefit {
namespace {

using ::testing::HasSubstr;

PointCloud RandomCloud(int n, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> coordinate(-1, 1);
  std::normal_distribution<float> direction;
  PointCloud cloud;
  cloud.points = Points3f::NullaryExpr(3, n, [&] { return coordinate(random); });
  cloud.normals =
      Points3f::NullaryExpr(3, n, [&] { return direction(random); }).eval().colwise().normalized();
  return cloud;
}

// Index in `cloud` of the point nearest to x.
Eigen::Index Nearest(const PointCloud& cloud, const Eigen::Vector3f& x) {
  Eigen::Index index = 0;
  (cloud.points.colwise() - x).colwise().squaredNorm().minCoeff(&index);
  return index;
}

TEST(DracoCloudTest, BringsPointsAndTheirNormalsBackWithinTheGridStep) {
  const PointCloud cloud = RandomCloud(2000, 1);
  for (int bits : {8, 11, 14, 20, 30}) {
    DracoCloudOptions options;
    options.position_bits = bits;
    options.normal_bits = 12;
    const auto decoded = DecodeDracoCloud(EncodeDracoCloud(cloud, options).value(), {});
    ASSERT_TRUE(decoded.ok()) << decoded.status();
    ASSERT_EQ(decoded->size(), cloud.size());
    const float step = 2.0f / static_cast<float>((1 << bits) - 1);
    for (Eigen::Index i = 0; i < decoded->size(); ++i) {
      const Eigen::Index j = Nearest(cloud, decoded->points.col(i));
      ASSERT_LE((decoded->points.col(i) - cloud.points.col(j)).cwiseAbs().maxCoeff(),
                0.5f * step + 6e-7f);
      ASSERT_NEAR(decoded->normals.col(i).norm(), 1, 1e-5);
      if (bits >= 14) {
        ASSERT_GT(decoded->normals.col(i).dot(cloud.normals.col(j)), 1 - 1e-5);
      }
    }
  }
}

TEST(DracoCloudTest, IsAlwaysKdTreeCoded) {
  const PointCloud cloud = RandomCloud(100, 2);
  for (int speed = 0; speed <= 10; ++speed) {
    DracoCloudOptions options;
    options.speed = speed;
    const std::string bytes = EncodeDracoCloud(cloud, options).value();
    EXPECT_EQ(bytes[8], 1) << "method byte at speed " << speed;
  }
}

TEST(DracoCloudTest, KeepsTheGridOfAGivenBoxWhateverTheCloud) {
  DracoCloudOptions options;
  options.box = {{-2, -2, -2}, {2, 2, 2}};
  const PointCloud whole = RandomCloud(300, 3);
  const auto first = DecodeDracoCloud(EncodeDracoCloud(whole, options).value(), {}).value();
  PointCloud half;
  half.points = whole.points.leftCols(150);
  half.normals = whole.normals.leftCols(150);
  const auto second = DecodeDracoCloud(EncodeDracoCloud(half, options).value(), {}).value();
  for (Eigen::Index i = 0; i < second.size(); ++i) {
    const Eigen::Index j = Nearest(first, second.points.col(i));
    ASSERT_EQ(second.points.col(i), first.points.col(j));
    ASSERT_EQ(second.normals.col(i), first.normals.col(j));
  }
}

TEST(DracoCloudTest, TakesPointsOnTheFacesOfTheBox) {
  PointCloud cloud;
  cloud.points.resize(3, 2);
  cloud.points << 0.1f, 0.7f, -0.3f, 0.1f, 1e6f, 1e6f + 1;
  DracoCloudOptions options;
  options.box = BoundingBox(cloud.points);
  const auto decoded = DecodeDracoCloud(EncodeDracoCloud(cloud, options).value(), {});
  ASSERT_TRUE(decoded.ok()) << decoded.status();
  EXPECT_LT((decoded->points - cloud.points).cwiseAbs().maxCoeff(), 0.2f);
}

TEST(DracoCloudTest, EncodesASinglePoint) {
  PointCloud cloud;
  cloud.points = Eigen::Vector3f(3, -4, 5);
  const auto decoded = DecodeDracoCloud(EncodeDracoCloud(cloud, {}).value(), {});
  ASSERT_TRUE(decoded.ok()) << decoded.status();
  EXPECT_EQ(decoded->points.col(0), Eigen::Vector3f(3, -4, 5));
  EXPECT_FALSE(decoded->has_normals());
}

TEST(DracoCloudTest, RefusesWhatItCannotEncodeAndNamesIt) {
  const PointCloud good = RandomCloud(50, 4);
  const auto message = [](const PointCloud& cloud, const DracoCloudOptions& options) {
    const absl::Status status = EncodeDracoCloud(cloud, options).status();
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
    return std::string(status.message());
  };
  DracoCloudOptions options;
  options.position_bits = 31;
  EXPECT_THAT(message(good, options), HasSubstr("position_bits is 31"));
  options = {};
  options.normal_bits = 1;
  EXPECT_THAT(message(good, options), HasSubstr("normal_bits is 1"));
  options = {};
  options.speed = 11;
  EXPECT_THAT(message(good, options), HasSubstr("speed is 11"));
  options = {};
  options.box = {{-1, -1, -1}, {1, 1, 0}};
  EXPECT_THAT(message(good, options), HasSubstr("outside the quantisation box"));
  PointCloud bad = good;
  bad.points(1, 17) = std::nanf("");
  EXPECT_THAT(message(bad, {}), HasSubstr("points: 17 = "));
  bad = good;
  bad.normals.col(3) *= 2;
  EXPECT_THAT(message(bad, {}), HasSubstr("normals: not unit vectors"));
  bad = good;
  bad.normals.conservativeResize(3, 49);
  EXPECT_THAT(message(bad, {}), HasSubstr("normals: 49 for 50 points"));
  EXPECT_THAT(message(PointCloud(), {}), HasSubstr("none to encode"));
}

TEST(DracoCloudTest, LeavesOutPointsWhoseNormalHasNoDirection) {
  PointCloud cloud = RandomCloud(40, 5);
  cloud.normals.col(7).setZero();
  cloud.normals.col(39).setZero();
  for (const std::string& bytes : {EncodeDracoCloud(cloud, {}).value(),
                                   testing::SequentialCloudBytes(cloud.points, cloud.normals)}) {
    const auto decoded = DecodeDracoCloud(bytes, {});
    ASSERT_TRUE(decoded.ok()) << decoded.status();
    EXPECT_EQ(decoded->size(), 38);
    EXPECT_EQ(decoded->normals.cols(), 38);
    for (Eigen::Index i = 0; i < decoded->size(); ++i) {
      EXPECT_NEAR(decoded->normals.col(i).norm(), 1, 1e-5);
    }
  }
}

TEST(DracoCloudTest, RefusesPointsAndNormalsThatAreNotFinite) {
  const PointCloud good = RandomCloud(20, 6);
  for (const float bad : {std::nanf(""), HUGE_VALF, -HUGE_VALF}) {
    Points3f points = good.points, normals = good.normals;
    points(2, 11) = bad;
    absl::Status status =
        DecodeDracoCloud(testing::SequentialCloudBytes(points, good.normals), {}).status();
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
    EXPECT_THAT(status.message(), HasSubstr("position of point 11"));
    normals(0, 12) = bad;
    status = DecodeDracoCloud(testing::SequentialCloudBytes(good.points, normals), {}).status();
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
    EXPECT_THAT(status.message(), HasSubstr("normal of point 12"));
  }
}

TEST(DracoCloudTest, RefusesPositionsOfTypeBool) {
  draco::PointCloud cloud;
  cloud.set_num_points(20);
  auto attribute = std::make_unique<draco::PointAttribute>();
  attribute->Init(draco::GeometryAttribute::POSITION, 3, draco::DT_BOOL, false, 20);
  attribute->SetIdentityMapping();
  const std::vector<uint8_t> values(60, 128);
  attribute->buffer()->Write(0, values.data(), values.size());
  cloud.AddAttribute(std::move(attribute));
  draco::ExpertEncoder encoder(cloud);
  encoder.SetEncodingMethod(draco::POINT_CLOUD_SEQUENTIAL_ENCODING);
  draco::EncoderBuffer buffer;
  ASSERT_TRUE(encoder.EncodeToBuffer(&buffer).ok());
  const auto decoded = DecodeDracoCloud({buffer.data(), buffer.size()}, DecodeLimits());
  EXPECT_EQ(decoded.status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_NE(decoded.status().message().find("of type bool"), absl::string_view::npos)
      << decoded.status();
}

TEST(DracoCloudTest, TakesAMeshWithItsOwnNormals) {
  const TriangleMesh grid = testing::WavyGrid(6);
  const auto cloud = DecodeDracoCloud(testing::EdgebreakerBytes(grid, {true, false, false}), {});
  ASSERT_TRUE(cloud.ok()) << cloud.status();
  EXPECT_EQ(cloud->size(), 36);
  for (Eigen::Index i = 0; i < cloud->size(); ++i) EXPECT_GT(cloud->normals(2, i), 0.9999f);
}

TEST(DracoCloudTest, GivesAMeshWithoutNormalsAngleWeightedOnes) {
  const TriangleMesh grid = testing::WavyGrid(6);
  const auto cloud = DecodeDracoCloud(EncodeDracoMesh(grid, {}).value(), {});
  ASSERT_TRUE(cloud.ok()) << cloud.status();
  const PointCloud expected = CloudFromMesh(grid);
  ASSERT_EQ(cloud->size(), expected.size());
  EXPECT_LT((cloud->points - expected.points).cwiseAbs().maxCoeff(), 1e-6f);
  EXPECT_LT((cloud->normals - expected.normals).cwiseAbs().maxCoeff(), 1e-5f);
}

}  // namespace
}  // namespace cagefit
