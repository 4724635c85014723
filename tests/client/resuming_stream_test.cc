#include "client/resuming_stream.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <future>
#include <random>
#include <thread>

#include "client/status_from_grpc.h"
#include "tests/client/fake_fitting.h"

namespace cagefit::client {
namespace {

using testing::FakeFitting;
using ::testing::HasSubstr;
using testing::kFakeFramesInFlight;
using testing::Place;

constexpr uint64_t kFrames = 12;

OutgoingFrame FrameOf(uint64_t number) {
  OutgoingFrame frame;
  frame.sequence_number = number;
  frame.draco = absl::StrCat(number % 5 == 3 ? "bad" : "good", " frame ", number);
  return frame;
}

// Tries again without waiting.
ResumeOptions AtOnce() {
  ResumeOptions options;
  options.sleep = [](absl::Duration) {};
  options.retry.most_refusals = 1'000;
  return options;
}

// What came of a sequence: all replies, then how it ended.
struct Course {
  std::vector<FittedFrame> frames;
  absl::Status end;
};

Course SendAll(FitClient* client, ResumeOptions options, uint64_t frames = kFrames) {
  ResumingStream stream(client, "a-session", std::move(options));
  Course course;
  course.end = stream.Open();
  if (!course.end.ok()) return course;
  std::thread sender([&] {
    for (uint64_t number = stream.next_sequence_number(); number < frames; ++number) {
      if (!stream.Send(FrameOf(number)).ok()) return;
    }
    stream.CloseSending().IgnoreError();
  });
  while (true) {
    auto frame = stream.Receive();
    course.end = frame.status();
    if (!frame.ok() || !frame->has_value()) break;
    course.frames.push_back(**std::move(frame));
  }
  stream.Cancel();
  sender.join();
  return course;
}

void ExpectUndisturbed(const Course& course) {
  ASSERT_EQ(course.end, absl::OkStatus());
  ASSERT_EQ(course.frames.size(), kFrames);
  Points3d vertices;
  for (uint64_t number = 0; number < kFrames; ++number) {
    const FittedFrame& frame = course.frames[number];
    EXPECT_EQ(frame.reply.sequence_number(), number);
    const OutgoingFrame sent = FrameOf(number);
    if (absl::StartsWith(sent.draco, "bad")) {
      EXPECT_TRUE(absl::IsInvalidArgument(frame.status)) << frame.status;
    } else {
      EXPECT_EQ(frame.status, absl::OkStatus());
      vertices = Dequantize(testing::FakeState(sent.draco), {{0, 0, 0}, 0.5});
    }
    EXPECT_EQ(frame.control_vertices, vertices) << number;
  }
}

// Breaks a stream once, when it is at `place` for the `time`th time.
FakeFitting::Breaks Once(Place place, int time, grpc::Status status) {
  const auto count = std::make_shared<std::atomic<int>>(0);
  return [=](Place at, grpc::ServerContext*) {
    return at == place && ++*count == time ? status : grpc::Status::OK;
  };
}

const grpc::Status kGone(grpc::StatusCode::UNAVAILABLE, "gone");

TEST(ResumingStreamTest, IsAStreamLikeAnyOtherWhileNothingBreaks) {
  FakeFitting service;
  ExpectUndisturbed(SendAll(service.Connect().get(), AtOnce()));
  EXPECT_EQ(service.opened(), 1);
}

TEST(ResumingStreamTest, GoesOnWhereverTheStreamBreaks) {
  for (const Place place : {Place::kBeforeOpened, Place::kOpened, Place::kInFrame,
                            Place::kBeforeFit, Place::kBeforeReply, Place::kAfterReply}) {
    const bool once_a_stream = place == Place::kBeforeOpened || place == Place::kOpened;
    for (const int time : {1, once_a_stream ? 1 : 5, once_a_stream ? 1 : 12}) {
      FakeFitting service(Once(place, time, kGone));
      SCOPED_TRACE(absl::StrCat("place ", static_cast<int>(place), ", time ", time));
      ExpectUndisturbed(SendAll(service.Connect().get(), AtOnce()));
      EXPECT_EQ(service.answered(), kFrames);
    }
  }
}

TEST(ResumingStreamTest, AFrameWhoseReplyWasLostGetsItsStoredOne) {
  FakeFitting service(Once(Place::kBeforeReply, 6, kGone));
  const Course course = SendAll(service.Connect().get(), AtOnce());
  ExpectUndisturbed(course);
  EXPECT_TRUE(course.frames[5].reply.repeated_reply());
  EXPECT_TRUE(course.frames[5].reply.delta().key());
  EXPECT_TRUE(course.frames[6].reply.delta().key());
  EXPECT_FALSE(course.frames[7].reply.delta().key());
}

// Streams break at random places with the codes that dead servers have, directly and behind
// proxies.
TEST(ResumingStreamTest, EveryFrameIsAnsweredOnceAndInOrderWhateverBreaks) {
  for (uint32_t seed = 0; seed < 300; ++seed) {
    std::mt19937 random(seed);
    const double often = std::uniform_real_distribution<double>(0.02, 0.4)(random);
    FakeFitting service([&](Place, grpc::ServerContext*) {
      if (std::uniform_real_distribution<double>()(random) > often) return grpc::Status::OK;
      constexpr grpc::StatusCode kCodes[] = {
          grpc::StatusCode::UNAVAILABLE, grpc::StatusCode::INTERNAL, grpc::StatusCode::UNKNOWN,
          grpc::StatusCode::DEADLINE_EXCEEDED, grpc::StatusCode::RESOURCE_EXHAUSTED};
      return grpc::Status(kCodes[random() % 5], "broken");
    });
    SCOPED_TRACE(absl::StrCat("seed ", seed));
    ExpectUndisturbed(SendAll(service.Connect().get(), AtOnce()));
    ASSERT_FALSE(HasFailure());
  }
}

TEST(ResumingStreamTest, AStreamThatANewerOneSupersededIsFinal) {
  FakeFitting service(
      Once(Place::kBeforeFit, 4, {grpc::StatusCode::ABORTED, "epoch 1 was superseded"}));
  const Course course = SendAll(service.Connect().get(), AtOnce());
  EXPECT_TRUE(absl::IsAborted(course.end)) << course.end;
  EXPECT_EQ(course.frames.size(), 3u);
  EXPECT_EQ(service.opened(), 1);
}

TEST(ResumingStreamTest, GivesUpWithTheLastErrorWhenTheServerStaysAway) {
  FakeFitting service([](Place place, grpc::ServerContext*) {
    return place == Place::kBeforeReply ? kGone : grpc::Status::OK;
  });
  absl::Time now = absl::UnixEpoch();
  ResumeOptions options;
  options.retry.now = [&] { return now; };
  options.sleep = [&](absl::Duration pause) { now += pause; };
  options.retry.give_up_after = absl::Seconds(5);
  int breaks = 0;
  options.on_break = [&](const absl::Status&) { ++breaks; };
  // A frame that only ever breaks its stream: the stored reply, too, is never written.
  const Course course = SendAll(service.Connect().get(), options);
  EXPECT_TRUE(absl::IsUnavailable(course.end)) << course.end;
  EXPECT_THAT(std::string(course.end.message()), HasSubstr("gone; tried again for "));
  EXPECT_TRUE(course.frames.empty());
  EXPECT_GT(breaks, 5);
}

TEST(ResumingStreamTest, TriesToOpenEvenTheFirstTime) {
  int times = 0;
  FakeFitting service([&](Place place, grpc::ServerContext*) {
    return place == Place::kBeforeOpened && ++times < 4 ? kGone : grpc::Status::OK;
  });
  ExpectUndisturbed(SendAll(service.Connect().get(), AtOnce()));
  EXPECT_EQ(service.opened(), 1);
}

TEST(ResumingStreamTest, WaitsAsLongAsAnExhaustedServerSays) {
  int times = 0;
  FakeFitting service([&](Place place, grpc::ServerContext* context) {
    if (place != Place::kBeforeOpened || ++times > 1) return grpc::Status::OK;
    v1::ErrorDetail detail;
    detail.mutable_retry_after()->set_seconds(9);
    context->AddTrailingMetadata("cagefit-error-detail-bin", detail.SerializeAsString());
    return grpc::Status(grpc::StatusCode::RESOURCE_EXHAUSTED, "busy");
  });
  std::vector<absl::Duration> pauses;
  ResumeOptions options;
  options.sleep = [&](absl::Duration pause) { pauses.push_back(pause); };
  ExpectUndisturbed(SendAll(service.Connect().get(), options));
  ASSERT_EQ(pauses.size(), 1u);
  EXPECT_GE(pauses[0], absl::Seconds(9));
}

TEST(ResumingStreamTest, AStoreThatWentBackIsDataLossWithBothNumbers) {
  FakeFitting* running = nullptr;
  int fits = 0;
  FakeFitting service([&](Place place, grpc::ServerContext*) {
    if (place != Place::kBeforeFit || ++fits != 8) return grpc::Status::OK;
    running->GoBackTo(2);
    return kGone;
  });
  running = &service;
  const Course course = SendAll(service.Connect().get(), AtOnce());
  EXPECT_TRUE(absl::IsDataLoss(course.end)) << course.end;
  EXPECT_THAT(std::string(course.end.message()), HasSubstr("expects frame 2 "));
  EXPECT_THAT(std::string(course.end.message()), HasSubstr("before frame 7"));
}

TEST(ResumingStreamTest, ALostConnectionAfterTheLastReplyIsNoError) {
  FakeFitting service(Once(Place::kAfterReply, kFrames, kGone));
  ExpectUndisturbed(SendAll(service.Connect().get(), AtOnce()));
}

TEST(ResumingStreamTest, CancelEndsWaitingForRoomAndForTheNextTry) {
  FakeFitting service(Once(Place::kBeforeFit, 1, kGone));
  const auto client = service.Connect();
  ResumeOptions options;
  options.retry.first_pause = options.retry.longest_pause = absl::Hours(1);
  options.retry.give_up_after = absl::InfiniteDuration();
  std::promise<void> broke;
  options.on_break = [&](const absl::Status&) { broke.set_value(); };
  ResumingStream stream(client.get(), "a-session", options);
  ASSERT_EQ(stream.Open(), absl::OkStatus());
  std::atomic<int> sent{0};
  std::thread sender([&] {
    for (uint64_t number = 0; stream.Send(FrameOf(number)).ok(); ++number) ++sent;
  });
  std::thread receiver([&] { EXPECT_TRUE(absl::IsCancelled(stream.Receive().status())); });
  broke.get_future().wait();
  while (sent <= kFakeFramesInFlight) std::this_thread::yield();
  stream.Cancel();
  sender.join();
  receiver.join();
  EXPECT_EQ(sent, kFakeFramesInFlight + 1);
}

}  // namespace
}  // namespace cagefit::client
