#include "server/transport/frame_assembler.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "server/session/error_detail.h"

namespace cagefit::server {
namespace {

using ::testing::HasSubstr;

v1::FitFramesRequest Header(uint64_t number, uint64_t total_bytes) {
  v1::FitFramesRequest request;
  request.mutable_header()->set_sequence_number(number);
  request.mutable_header()->set_total_bytes(total_bytes);
  return request;
}

v1::FitFramesRequest Chunk(const std::string& data) {
  v1::FitFramesRequest request;
  request.mutable_chunk()->set_data(data);
  return request;
}

class FrameAssemblerTest : public ::testing::Test {
 protected:
  absl::StatusOr<std::optional<ReceivedFrame>> Add(v1::FitFramesRequest request) {
    return assembler_.Add(&request);
  }
  // Adds a message that does not complete a frame.
  void AddPart(v1::FitFramesRequest request) {
    const auto added = Add(std::move(request));
    ASSERT_TRUE(added.ok()) << added.status();
    EXPECT_FALSE(added->has_value());
  }
  void ExpectRefused(v1::FitFramesRequest request, const std::string& reason,
                     const std::string& field) {
    const absl::Status status = Add(std::move(request)).status();
    const auto detail = DetailOf(status);
    ASSERT_TRUE(detail.has_value()) << status;
    EXPECT_EQ(detail->reason, reason) << status;
    EXPECT_EQ(detail->field, field) << status;
    EXPECT_EQ(absl::IsResourceExhausted(status), reason == "LIMIT_EXCEEDED") << status;
    EXPECT_EQ(absl::IsInvalidArgument(status), reason != "LIMIT_EXCEEDED") << status;
  }

  MemoryAccount budget_{"bytes in flight of all calls", 4 << 20};
  FrameAssembler assembler_{3 << 20, &budget_};
};

TEST_F(FrameAssemblerTest, PutsAFrameTogetherFromItsChunks) {
  v1::FitFramesRequest header = Header(7, 6);
  header.mutable_header()->set_point_count(99);
  header.mutable_header()->mutable_timestamp()->set_seconds(12);
  header.mutable_header()->mutable_timestamp()->set_nanos(34);
  AddPart(header);
  AddPart(Chunk("abc"));
  AddPart(Chunk("d"));
  const auto added = Add(Chunk("ef"));
  ASSERT_TRUE(added.ok()) << added.status();
  ASSERT_TRUE(added->has_value());
  const Frame& frame = (*added)->frame;
  EXPECT_EQ(frame.bytes, "abcdef");
  EXPECT_EQ(frame.sequence_number, 7u);
  EXPECT_EQ(frame.point_count, 99u);
  EXPECT_EQ(frame.timestamp, absl::FromUnixSeconds(12) + absl::Nanoseconds(34));
}

TEST_F(FrameAssemblerTest, MasksAreStatedInTheHeader) {
  v1::FitFramesRequest header = Header(0, 3);
  v1::Mask* mask = header.mutable_header()->add_masks();
  mask->set_camera("left");
  mask->set_png_bytes(2);
  AddPart(header);
  const auto added = Add(Chunk("abc"));
  ASSERT_TRUE(added.ok() && added->has_value()) << added.status();
  ASSERT_EQ((*added)->frame.stated_masks.size(), 1u);
  EXPECT_EQ((*added)->frame.stated_masks[0].camera, "left");
  EXPECT_EQ((*added)->frame.stated_masks[0].png_bytes, 2u);
}

TEST_F(FrameAssemblerTest, LandmarksAreStatedInTheHeader) {
  v1::FitFramesRequest header = Header(0, 1);
  v1::Landmark* on_vertex = header.mutable_header()->add_landmarks();
  on_vertex->set_vertex(7);
  on_vertex->set_y(2.5);
  v1::Landmark* on_surface = header.mutable_header()->add_landmarks();
  on_surface->mutable_surface()->set_triangle(9);
  on_surface->mutable_surface()->set_v(0.25);
  AddPart(header);
  const auto added = Add(Chunk("x"));
  ASSERT_TRUE(added.ok() && added->has_value());
  const std::vector<Landmark>& landmarks = (*added)->frame.landmarks;
  ASSERT_EQ(landmarks.size(), 2u);
  EXPECT_EQ(landmarks[0].vertex, 7);
  EXPECT_EQ(landmarks[0].position, Eigen::Vector3d(0, 2.5, 0));
  EXPECT_EQ(landmarks[1].vertex, -1);
  EXPECT_EQ(landmarks[1].at.face, 9);
  EXPECT_EQ(landmarks[1].at.u, 0);
  EXPECT_EQ(landmarks[1].at.v, 0.25);
}

TEST_F(FrameAssemblerTest, RefusesLandmarksThatNoMeshHas) {
  v1::FitFramesRequest nowhere = Header(0, 1);
  nowhere.mutable_header()->add_landmarks()->set_vertex(1);
  nowhere.mutable_header()->add_landmarks()->set_x(1);
  ExpectRefused(nowhere, "INVALID_FIELD", "header.landmarks[1].place");
  v1::FitFramesRequest beyond = Header(0, 1);
  beyond.mutable_header()->add_landmarks()->mutable_surface()->set_triangle(1u << 31);
  ExpectRefused(beyond, "INVALID_FIELD", "header.landmarks[0].surface.triangle");
  v1::FitFramesRequest many = Header(0, 1);
  for (int k = 0; k <= kMaxLandmarks; ++k) many.mutable_header()->add_landmarks()->set_vertex(1);
  ExpectRefused(many, "LIMIT_EXCEEDED", "header.landmarks");
}

TEST_F(FrameAssemblerTest, TakesOneFrameAfterAnother) {
  for (uint64_t number = 0; number < 3; ++number) {
    AddPart(Header(number, 3));
    const auto added = Add(Chunk("abc"));
    ASSERT_TRUE(added.ok() && added->has_value()) << added.status();
    EXPECT_EQ((*added)->frame.sequence_number, number);
    EXPECT_FALSE((*added)->frame.timestamp.has_value());
    EXPECT_EQ(assembler_.CheckBetweenFrames(), absl::OkStatus());
  }
}

TEST_F(FrameAssemblerTest, AFrameWithoutBytesIsCompleteWithItsHeader) {
  const auto added = Add(Header(0, 0));
  ASSERT_TRUE(added.ok()) << added.status();
  EXPECT_TRUE(added->has_value());
}

TEST_F(FrameAssemblerTest, TakesChunksUpToTheirLimit) {
  AddPart(Header(0, (1 << 20) + 1));
  ExpectRefused(Chunk(std::string((1 << 20) + 1, 'x')), "INVALID_FIELD", "chunk.data");
  AddPart(Chunk(std::string(1 << 20, 'x')));
  EXPECT_TRUE(Add(Chunk("x"))->has_value());
}

TEST_F(FrameAssemblerTest, RefusesAnEmptyChunk) {
  AddPart(Header(0, 3));
  ExpectRefused(Chunk(""), "INVALID_FIELD", "chunk.data");
}

TEST_F(FrameAssemblerTest, RefusesMoreBytesThanStated) {
  AddPart(Header(0, 3));
  AddPart(Chunk("ab"));
  const absl::Status status = Add(Chunk("cd")).status();
  EXPECT_TRUE(absl::IsInvalidArgument(status)) << status;
  EXPECT_THAT(std::string(status.message()), HasSubstr("4 bytes in all"));
  EXPECT_THAT(std::string(status.message()), HasSubstr("header.total_bytes is 3"));
}

TEST_F(FrameAssemblerTest, RefusesAHeaderWithinAFrame) {
  AddPart(Header(5, 3));
  AddPart(Chunk("ab"));
  ExpectRefused(Header(6, 3), "PROTOCOL_VIOLATION", "chunk");
  const absl::Status unfinished = assembler_.CheckBetweenFrames();
  EXPECT_TRUE(absl::IsInvalidArgument(unfinished)) << unfinished;
  EXPECT_THAT(std::string(unfinished.message()), HasSubstr("frame 5 has 2 of 3 bytes"));
}

TEST_F(FrameAssemblerTest, RefusesMessagesOutOfPlace) {
  ExpectRefused(Chunk("abc"), "PROTOCOL_VIOLATION", "chunk");
  ExpectRefused(v1::FitFramesRequest(), "PROTOCOL_VIOLATION", "message");
  v1::FitFramesRequest open;
  open.mutable_open()->set_session_id("again");
  ExpectRefused(open, "PROTOCOL_VIOLATION", "open");
}

TEST_F(FrameAssemblerTest, RefusesAnEncodingThatItDoesNotKnow) {
  v1::FitFramesRequest header = Header(0, 3);
  header.mutable_header()->set_encoding(static_cast<v1::FrameEncoding>(77));
  ExpectRefused(header, "INVALID_FIELD", "header.encoding");
}

TEST_F(FrameAssemblerTest, RefusesAFrameAboveTheLimitByItsHeader) {
  ExpectRefused(Header(0, (3 << 20) + 1), "LIMIT_EXCEEDED", "header.total_bytes");
  const absl::Status huge = Add(Header(0, ~uint64_t{0})).status();
  EXPECT_THAT(std::string(huge.message()), HasSubstr("is 18446744073709551615"));
  AddPart(Header(0, 3 << 20));
}

TEST_F(FrameAssemblerTest, TakesFromTheBudgetWhatHasArrived) {
  const std::string mebibyte(1 << 20, 'x');
  AddPart(Header(0, 3 << 20));
  EXPECT_EQ(budget_.taken(), 0);
  AddPart(Chunk(mebibyte));
  AddPart(Chunk(mebibyte));
  EXPECT_EQ(budget_.taken(), 2 << 20);
  {
    auto frame = Add(Chunk(mebibyte));
    ASSERT_TRUE(frame.ok() && frame->has_value()) << frame.status();
    EXPECT_EQ(budget_.taken(), 3 << 20);

    // The frame that is not answered yet leaves room for one more chunk.
    AddPart(Header(1, 3 << 20));
    AddPart(Chunk(mebibyte));
    ExpectRefused(Chunk(mebibyte), "LIMIT_EXCEEDED", "bytes in flight of all calls");
  }
  EXPECT_EQ(budget_.taken(), 1 << 20);
}

TEST_F(FrameAssemblerTest, AnUnfinishedFrameGivesItsBytesBack) {
  {
    FrameAssembler assembler(100, &budget_);
    v1::FitFramesRequest header = Header(0, 3), chunk = Chunk("ab");
    ASSERT_TRUE(assembler.Add(&header).ok());
    ASSERT_TRUE(assembler.Add(&chunk).ok());
    EXPECT_EQ(budget_.taken(), 2);
  }
  EXPECT_EQ(budget_.taken(), 0);
}

}  // namespace
}  // namespace cagefit::server
