#include "core/codec/draco_guard.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <random>

#include "tests/core/codec/draco_samples.h"
#include "tests/core/codec/measured_child.h"
#include "tests/support/sanitizer.h"

namespace cagefit {
namespace {

using testing::AllDracoSamples;
using testing::ChildReport;
using ::testing::HasSubstr;
using testing::NamedBytes;

constexpr size_t kHeaderBytes = 11;

DecodeLimits FileLimits() {
  DecodeLimits limits;
  limits.allow_metadata = true;
  return limits;
}

// True for one of the three answers that hostile bytes may get.
bool Decodes(const std::string& bytes) {
  const auto mesh = DecodeDracoMesh(bytes, FileLimits());
  if (mesh.ok()) return mesh->vertices.allFinite();
  return absl::IsInvalidArgument(mesh.status()) || absl::IsResourceExhausted(mesh.status());
}

TEST(DracoGuardTest, SamplesOfEveryMethodAreValid) {
  for (const NamedBytes& sample : AllDracoSamples()) {
    const auto geometry = DecodeGuarded(sample.bytes, FileLimits());
    ASSERT_TRUE(geometry.ok()) << sample.name << ": " << geometry.status();
    EXPECT_EQ(geometry->points->num_points(), 25u) << sample.name;
  }
}

TEST(DracoGuardTest, SurvivesTruncationAtEveryByte) {
  for (const NamedBytes& sample : AllDracoSamples()) {
    const ChildReport report = testing::RunInChild([&] {
      for (size_t size = 0; size < sample.bytes.size(); ++size) {
        if (!Decodes(sample.bytes.substr(0, size))) return 1;
      }
      return 0;
    });
    EXPECT_EQ(report.exit_code, 0) << sample.name << ", signal " << report.signal;
  }
}

TEST(DracoGuardTest, SurvivesRandomBytes) {
  for (const NamedBytes& sample : AllDracoSamples()) {
    const ChildReport report = testing::RunInChild([&] {
      std::mt19937 random(7);
      for (int i = 0; i < 3000; ++i) {
        std::string bytes = sample.bytes;
        for (int flips = 1 + i % 4; flips > 0; --flips) {
          bytes[kHeaderBytes + random() % (bytes.size() - kHeaderBytes)] =
              static_cast<char>(random());
        }
        if (!Decodes(bytes)) return 1;
      }
      return 0;
    });
    EXPECT_EQ(report.exit_code, 0) << sample.name << ", signal " << report.signal;
  }
}

// The number of points, of faces, of texture orientations and so on are all somewhere.
TEST(DracoGuardTest, PaysNothingForAHugeNumberAtAnyPlace) {
  for (const NamedBytes& sample : AllDracoSamples()) {
    for (const char* number : {"\x00\x00\x00\x7f", "\xff\xff\xff\x07", "\x00\x00\x80\x00"}) {
      const ChildReport report = testing::RunInChild([&] {
        for (size_t at = kHeaderBytes; at + 4 <= sample.bytes.size(); ++at) {
          std::string bytes = sample.bytes;
          std::memcpy(bytes.data() + at, number, 4);
          if (!Decodes(bytes)) return 1;
        }
        return 0;
      });
      EXPECT_EQ(report.exit_code, 0) << sample.name << ", signal " << report.signal;
      EXPECT_LT(report.cpu_ms, 1000 * testing::kCostFactor) << sample.name;
      EXPECT_LT(report.peak_mib, 128 * testing::kCostFactor) << sample.name;
    }
  }
}

TEST(DracoGuardTest, HoldsTheNumberOfPointsAgainstTheLimit) {
  DecodeLimits limits = FileLimits();
  limits.max_points = 24;
  for (const NamedBytes& sample : AllDracoSamples()) {
    const absl::Status status = DecodeGuarded(sample.bytes, limits).status();
    EXPECT_EQ(status.code(), absl::StatusCode::kResourceExhausted) << sample.name;
    EXPECT_THAT(status.message(), HasSubstr("max_points is 24, got 25")) << sample.name;
  }
}

TEST(DracoGuardTest, HoldsTheNumberOfFacesAgainstTheLimit) {
  DecodeLimits limits = FileLimits();
  limits.max_faces = 31;
  const std::string bytes = testing::EdgebreakerBytes(testing::WavyGrid(5), {});
  const absl::Status status = DecodeGuarded(bytes, limits).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kResourceExhausted);
  EXPECT_THAT(status.message(), HasSubstr("max_faces is 31, got 32"));
}

TEST(DracoGuardTest, HoldsTheMemoryAgainstTheLimit) {
  DecodeLimits limits = FileLimits();
  limits.max_decoded_bytes = 400;
  for (const NamedBytes& sample : AllDracoSamples()) {
    const absl::Status status = DecodeGuarded(sample.bytes, limits).status();
    EXPECT_EQ(status.code(), absl::StatusCode::kResourceExhausted) << sample.name;
    EXPECT_THAT(status.message(), HasSubstr("max_decoded_bytes is 400")) << sample.name;
  }
}

TEST(DracoGuardTest, RefusesAKdTreeThatRepeatsAnotherNumberOfPoints) {
  std::string bytes = AllDracoSamples()[1].bytes;
  // The repetition is the second place with the number 25 as 32 bits.
  const std::string number("\x19\x00\x00\x00", 4);
  const size_t at = bytes.find(number, bytes.find(number) + 4);
  ASSERT_NE(at, std::string::npos);
  bytes[at + 3] = 0x40;
  EXPECT_THAT(DecodeGuarded(bytes, {}).status().message(),
              HasSubstr("header says 25 points, its kd-tree 1073741849"));
}

TEST(DracoGuardTest, DoesNotBelieveMillionsOfPointsInAFewBytes) {
  for (const NamedBytes& sample : AllDracoSamples()) {
    const DracoInfo info = InspectDraco(sample.bytes).value();
    if (info.has_metadata) continue;
    std::string bytes = sample.bytes;
    const bool edgebreaker = info.is_mesh && bytes[8] == 1;
    if (info.is_mesh) {  // faces as a number of variable length, in edgebreaker after two others
      bytes.replace(kHeaderBytes + (edgebreaker ? 2 : 0), 3, "\xff\xff\x7f");
    } else {
      bytes.replace(kHeaderBytes, 4, std::string("\x00\x00\x20\x00", 4));
    }
    const absl::Status status = DecodeGuarded(bytes, {}).status();
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument) << sample.name;
    EXPECT_THAT(status.message(), HasSubstr("Draco bytes cannot hold 20971")) << sample.name;
  }
}

TEST(DracoGuardTest, RefusesTooManyComponentsAttributesAndUnknownTypes) {
  const std::string good =
      testing::SequentialCloudBytes(Points3f::Random(3, 50), Points3f::Random(3, 50));
  // One decoder, two attributes: type 0, float (9), 3 components, not normalised, id 0.
  ASSERT_EQ(good.substr(kHeaderBytes + 4, 6), std::string("\x01\x02\x00\x09\x03\x00", 6));
  const auto message = [&](size_t at, char value) {
    std::string bytes = good;
    bytes[kHeaderBytes + 4 + at] = value;
    const absl::Status status = DecodeGuarded(bytes, {}).status();
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
    return std::string(status.message());
  };
  EXPECT_THAT(message(0, 5), HasSubstr("5 attribute decoders"));
  EXPECT_THAT(message(1, 5), HasSubstr("5 attributes"));
  EXPECT_THAT(message(3, 12), HasSubstr("unknown data type 12"));
  EXPECT_THAT(message(4, '\xff'), HasSubstr("255 components"));
}

TEST(DracoGuardTest, RefusesFaceIndicesBeyondThePoints) {
  std::string bytes = EncodeDracoMesh(testing::WavyGrid(5), {}).value();
  // Numbers of faces and points, the way of coding, then indices of one byte.
  ASSERT_EQ(bytes.substr(kHeaderBytes, 3), std::string("\x20\x19\x01", 3));
  bytes[kHeaderBytes + 3 + 4] = 25;
  EXPECT_THAT(DecodeGuarded(bytes, {}).status().message(), HasSubstr("face 1 has vertex 25 of 25"));
}

}  // namespace
}  // namespace cagefit
