#include "core/codec/draco_header.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/codec/draco_codec.h"
#include "tests/core/codec/draco_samples.h"

namespace cagefit {
namespace {

using ::testing::HasSubstr;

std::string Header(int major, int minor, int geometry, int method, int flags_high = 0) {
  std::string bytes = "DRACO";
  for (int value : {major, minor, geometry, method, 0, flags_high}) {
    bytes.push_back(static_cast<char>(value));
  }
  return bytes;
}

TEST(DracoHeaderTest, TellsGeometryAndMethod) {
  EXPECT_EQ(ReadDracoHeader(Header(2, 3, 0, 0))->method, DracoMethod::kSequentialCloud);
  EXPECT_EQ(ReadDracoHeader(Header(2, 3, 0, 1))->method, DracoMethod::kKdTreeCloud);
  EXPECT_EQ(ReadDracoHeader(Header(2, 2, 1, 0))->method, DracoMethod::kSequentialMesh);
  EXPECT_EQ(ReadDracoHeader(Header(1, 0, 1, 1))->method, DracoMethod::kEdgebreakerMesh);
  EXPECT_TRUE(InspectDraco(Header(1, 1, 1, 1))->is_mesh);
  EXPECT_FALSE(InspectDraco(Header(1, 1, 0, 0))->is_mesh);
}

TEST(DracoHeaderTest, RefusesWhatItDoesNotKnow) {
  const auto message = [](const std::string& bytes) {
    const absl::Status status = InspectDraco(bytes).status();
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
    return std::string(status.message());
  };
  EXPECT_THAT(message(""), HasSubstr("not Draco"));
  EXPECT_THAT(message("\x89PNG\r\n\x1a\n and so on"), HasSubstr("not Draco"));
  EXPECT_THAT(message("DRACO\x02\x02"), HasSubstr("cut off after 7 bytes"));
  EXPECT_THAT(message(Header(0, 9, 1, 1)), HasSubstr("bitstream 0.9 of a mesh"));
  EXPECT_THAT(message(Header(2, 3, 1, 1)), HasSubstr("bitstream 2.3 of a mesh"));
  EXPECT_THAT(message(Header(2, 4, 0, 0)), HasSubstr("bitstream 2.4 of a point cloud"));
  EXPECT_THAT(message(Header(3, 0, 0, 0)), HasSubstr("bitstream 3.0"));
  EXPECT_THAT(message(Header(2, 2, 0, 1)), HasSubstr("only 2.3 is read"));
  EXPECT_THAT(message(Header(2, 2, 2, 0)), HasSubstr("geometry type 2"));
  EXPECT_THAT(message(Header(2, 2, 1, 7)), HasSubstr("method 7"));
}

TEST(DracoHeaderTest, KnowsMetadataFromBitstream13On) {
  EXPECT_TRUE(InspectDraco(Header(1, 3, 1, 0, 0x80))->has_metadata);
  EXPECT_FALSE(InspectDraco(Header(1, 2, 1, 0, 0x80))->has_metadata);
  EXPECT_FALSE(InspectDraco(Header(2, 2, 1, 0, 0x7f))->has_metadata);
}

TEST(DracoMetadataTest, IsRefusedUnlessAllowed) {
  const TriangleMesh grid = testing::WavyGrid(5);
  const std::string bytes = testing::EdgebreakerBytes(grid, {false, false, true});
  ASSERT_TRUE(InspectDraco(bytes)->has_metadata);
  const absl::Status status = DecodeDracoCloud(bytes, {}).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(status.message(), HasSubstr("metadata"));
  DecodeLimits limits;
  limits.allow_metadata = true;
  EXPECT_EQ(DecodeDracoMesh(bytes, limits)->vertices.cols(), 25);
}

TEST(DracoMetadataTest, IsStrippedWithoutTouchingTheGeometry) {
  const TriangleMesh grid = testing::WavyGrid(5);
  const std::string without = testing::EdgebreakerBytes(grid, {true, true, false});
  const std::string with = testing::EdgebreakerBytes(grid, {true, true, true});
  ASSERT_GT(with.size(), without.size());
  EXPECT_EQ(StripDracoMetadata(with).value(), without);
  EXPECT_EQ(StripDracoMetadata(without).value(), without);
}

TEST(DracoMetadataTest, EndsWhereItIsCutOffOrTooDeep) {
  const auto end = [](const std::string& tree) {
    return DracoMetadataEnd(Header(2, 2, 1, 0, 0x80) + tree);
  };
  // No attributes, no entries, no children: three zeros.
  EXPECT_EQ(end(std::string(3, '\0')).value(), kDracoHeaderBytes + 3);
  EXPECT_THAT(end("").status().message(), HasSubstr("cut off"));
  EXPECT_THAT(end(std::string("\x00\x01\x04na", 5)).status().message(), HasSubstr("cut off"));
  EXPECT_THAT(end("\xff\xff\xff\xff\xff\xff").status().message(), HasSubstr("endless number"));
  EXPECT_THAT(end(std::string("\x00\x01\x01n\xff\xff\xff\xff\x0f", 9)).status().message(),
              HasSubstr("cut off"));
  // Each level: no entries, one child with an empty name.
  std::string nested(1, '\0');
  for (int i = 0; i < 40; ++i) nested += std::string("\x00\x01\x00", 3);
  EXPECT_THAT(end(nested).status().message(), HasSubstr("nested deeper than 16"));
}

}  // namespace
}  // namespace cagefit
