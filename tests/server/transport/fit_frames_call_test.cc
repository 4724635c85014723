#include "server/transport/fit_frames_call.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <thread>

#include "absl/time/clock.h"
#include "tests/server/transport/service_fixture.h"

namespace cagefit::server {
namespace {

using cagefit::testing::FrameBytes;
using cagefit::testing::MovingCloud;
using testing::BoundedContext;
using testing::ServiceLimits;
using testing::TestService;

// A stream driven message by message.
class RawStream {
 public:
  explicit RawStream(TestService* service) : stream_(service->stub->FitFrames(&context_)) {}
  RawStream(TestService* service, absl::Duration deadline) {
    context_.set_deadline(absl::ToChronoTime(absl::Now() + deadline));
    stream_ = service->stub->FitFrames(&context_);
  }

  bool Open(const std::string& session_id, v1::FrameMode mode = v1::FRAME_MODE_UNSPECIFIED) {
    v1::FitFramesRequest request;
    request.mutable_open()->set_session_id(session_id);
    request.mutable_open()->set_mode(mode);
    return stream_->Write(request) && Read();
  }
  void Header(uint64_t number, uint64_t total_bytes) {
    v1::FitFramesRequest request;
    request.mutable_header()->set_sequence_number(number);
    request.mutable_header()->set_total_bytes(total_bytes);
    stream_->Write(request);
  }
  void Chunk(const std::string& data) {
    v1::FitFramesRequest request;
    request.mutable_chunk()->set_data(data);
    stream_->Write(request);
  }
  void Frame(uint64_t number) {
    const std::string bytes = FrameBytes(MovingCloud(static_cast<int>(number)));
    Header(number, bytes.size());
    Chunk(bytes);
  }
  void CloseSending() { stream_->WritesDone(); }
  bool Read() { return stream_->Read(&reply); }
  grpc::StatusCode End() {
    while (Read()) {
    }
    return stream_->Finish().error_code();
  }
  v1::ErrorDetail detail() const { return testing::DetailOf(context_); }

  v1::FitFramesReply reply;

 private:
  BoundedContext context_;
  std::unique_ptr<grpc::ClientReaderWriter<v1::FitFramesRequest, v1::FitFramesReply>> stream_;
};

TEST(FitFramesCallTest, OpensThenAnswersThenEndsWithOk) {
  TestService service;
  const std::string id = service.CreateSession();
  RawStream stream(&service);
  ASSERT_TRUE(stream.Open(id));
  EXPECT_EQ(stream.reply.opened().epoch(), 1u);
  EXPECT_EQ(stream.reply.opened().next_sequence_number(), 0u);
  EXPECT_EQ(stream.reply.opened().frames_in_flight(), static_cast<uint32_t>(kFramesInFlight));
  for (uint64_t number = 0; number < 3; ++number) {
    stream.Frame(number);
    ASSERT_TRUE(stream.Read());
    EXPECT_EQ(stream.reply.frame().sequence_number(), number);
    EXPECT_EQ(stream.reply.frame().outcome(), v1::OUTCOME_FITTED);
  }
  stream.CloseSending();
  EXPECT_EQ(stream.End(), grpc::StatusCode::OK);
  service.WaitForFits(id);
  EXPECT_EQ(service.budget.taken(), 0);
}

TEST(FitFramesCallTest, AnswersWhatItHasBeforeItEnds) {
  TestService service;
  RawStream stream(&service);
  ASSERT_TRUE(stream.Open(service.CreateSession()));
  stream.Frame(0);
  stream.Frame(1);
  stream.Header(2, 10);  // never completed
  stream.CloseSending();
  ASSERT_TRUE(stream.Read());
  EXPECT_EQ(stream.reply.frame().sequence_number(), 0u);
  ASSERT_TRUE(stream.Read());
  EXPECT_EQ(stream.reply.frame().sequence_number(), 1u);
  EXPECT_EQ(stream.End(), grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_EQ(stream.detail().reason(), "PROTOCOL_VIOLATION");
}

TEST(FitFramesCallTest, ExpectsToBeOpenedFirst) {
  TestService service;
  RawStream stream(&service);
  stream.Frame(0);
  EXPECT_EQ(stream.End(), grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_EQ(stream.detail().field(), "open");

  RawStream silent(&service);
  silent.CloseSending();
  EXPECT_EQ(silent.End(), grpc::StatusCode::INVALID_ARGUMENT);
}

TEST(FitFramesCallTest, OpensOnce) {
  TestService service;
  const std::string id = service.CreateSession();
  RawStream stream(&service);
  ASSERT_TRUE(stream.Open(id));
  EXPECT_FALSE(stream.Open(id));
  EXPECT_EQ(stream.End(), grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_EQ(stream.detail().reason(), "PROTOCOL_VIOLATION");
}

TEST(FitFramesCallTest, AnUnknownSessionIsNotFound) {
  TestService service;
  RawStream stream(&service);
  EXPECT_FALSE(stream.Open("nobody"));
  EXPECT_EQ(stream.End(), grpc::StatusCode::NOT_FOUND);
}

TEST(FitFramesCallTest, AGapEndsTheStreamWithTheExpectedNumber) {
  TestService service;
  RawStream stream(&service);
  ASSERT_TRUE(stream.Open(service.CreateSession()));
  stream.Frame(3);
  EXPECT_EQ(stream.End(), grpc::StatusCode::OUT_OF_RANGE);
  EXPECT_EQ(stream.detail().reason(), "SEQUENCE_GAP");
  EXPECT_EQ(stream.detail().limit(), "0");
}

TEST(FitFramesCallTest, DeletingTheSessionEndsItsStream) {
  TestService service;
  const std::string id = service.CreateSession();
  RawStream stream(&service);
  ASSERT_TRUE(stream.Open(id));
  ASSERT_TRUE(service.store.Delete(id).ok());
  EXPECT_EQ(stream.End(), grpc::StatusCode::ABORTED);
  EXPECT_EQ(stream.detail().reason(), "SESSION_DELETED");
}

TEST(FitFramesCallTest, TooManyStreamsAreExhaustion) {
  ServiceLimits limits;
  limits.max_streams = 1;
  TestService service(limits);
  const std::string id = service.CreateSession();
  RawStream first(&service);
  ASSERT_TRUE(first.Open(id));
  RawStream second(&service);
  EXPECT_FALSE(second.Open(id));
  EXPECT_EQ(second.End(), grpc::StatusCode::RESOURCE_EXHAUSTED);
  EXPECT_EQ(second.detail().field(), "open streams");
  first.Frame(0);
  EXPECT_TRUE(first.Read());
}

TEST(FitFramesCallTest, AFullQueueEndsTheStreamWithExhaustion) {
  ServiceLimits limits;
  limits.scheduler.max_queued = 0;
  TestService service(limits);
  RawStream stream(&service);
  EXPECT_FALSE(stream.Open(service.CreateSession()));
  EXPECT_EQ(stream.End(), grpc::StatusCode::RESOURCE_EXHAUSTED);
}

TEST(FitFramesCallTest, AnExhaustedBudgetEndsTheStreamAndNothingIsKept) {
  ServiceLimits limits;
  limits.budget_bytes = 10;
  TestService service(limits);
  RawStream stream(&service);
  ASSERT_TRUE(stream.Open(service.CreateSession()));
  stream.Frame(0);
  EXPECT_EQ(stream.End(), grpc::StatusCode::RESOURCE_EXHAUSTED);
  EXPECT_EQ(stream.detail().limit(), "10");
}

TEST(FitFramesCallTest, DrainingAnswersNoNewStream) {
  TestService service;
  const std::string id = service.CreateSession();
  RawStream stream(&service);
  ASSERT_TRUE(stream.Open(id));
  service.streams.DrainAll();
  EXPECT_EQ(stream.End(), grpc::StatusCode::UNAVAILABLE);
  EXPECT_EQ(stream.detail().reason(), "DRAINING");
  RawStream late(&service);
  EXPECT_FALSE(late.Open(id));
  EXPECT_EQ(late.End(), grpc::StatusCode::UNAVAILABLE);
}

// ---- FRAME_MODE_LATEST ----

// Keeps the fits of a session waiting until it is destroyed.
class HeldFits {
 public:
  HeldFits(TestService* service, const std::string& session_id) {
    EXPECT_TRUE(service->scheduler.fits
                    .Run(session_id,
                         [this, held = let_go_.get_future().share()] {
                           holds_.set_value();
                           held.wait();
                         })
                    .ok());
    holds_.get_future().wait();
  }
  ~HeldFits() { let_go_.set_value(); }

 private:
  std::promise<void> holds_, let_go_;
};

// Until a condition holds, which it must before long.
void WaitFor(const std::function<bool()>& condition) {
  const absl::Time end = absl::Now() + absl::Seconds(30);
  while (!condition()) {
    ASSERT_LT(absl::Now(), end);
    absl::SleepFor(absl::Milliseconds(1));
  }
}

// Opens a stream and sends `frames` frames while the first one waits to be fitted.
void SendWhileTheFirstWaits(TestService* service, const std::string& id, uint64_t frames,
                            RawStream* stream) {
  ASSERT_TRUE(stream->Open(id, v1::FRAME_MODE_LATEST));
  EXPECT_EQ(stream->reply.opened().frames_in_flight(), static_cast<uint32_t>(kLatestInFlight));
  const HeldFits held(service, id);
  stream->Frame(0);
  WaitFor([service] { return service->scheduler.fits.queued() == 1; });
  const int64_t of_first = service->budget.taken();
  for (uint64_t number = 1; number < frames; ++number) stream->Frame(number);
  // All have arrived, and of those that wait only the last is still there.
  const auto last = static_cast<int64_t>(FrameBytes(MovingCloud(frames - 1)).size());
  WaitFor([&] { return service->budget.taken() == of_first + last; });
}

TEST(FitFramesCallTest, InLatestModeTheNewestFrameThatWaitsIsFittedNext) {
  TestService service;
  const std::string id = service.CreateSession();
  RawStream stream(&service);
  SendWhileTheFirstWaits(&service, id, 6, &stream);
  for (uint64_t number = 0; number < 6; ++number) {
    ASSERT_TRUE(stream.Read());
    EXPECT_EQ(stream.reply.frame().sequence_number(), number);
    const bool is_fitted = number == 0 || number == 5;
    EXPECT_EQ(stream.reply.frame().outcome(), is_fitted ? v1::OUTCOME_FITTED : v1::OUTCOME_SKIPPED);
    EXPECT_EQ(stream.reply.frame().has_delta(), is_fitted);
  }
  // And it goes on.
  stream.Frame(6);
  ASSERT_TRUE(stream.Read());
  EXPECT_EQ(stream.reply.frame().outcome(), v1::OUTCOME_FITTED);
  stream.CloseSending();
  EXPECT_EQ(stream.End(), grpc::StatusCode::OK);
  EXPECT_EQ((*service.store.Find(id))->Facts().skipped_frames, 4u);
  service.WaitForFits(id);
  EXPECT_EQ(service.budget.taken(), 0);
}

TEST(FitFramesCallTest, InLatestModeASlowReaderGetsEveryAnswer) {
  TestService service;
  const std::string id = service.CreateSession();
  RawStream stream(&service);
  ASSERT_TRUE(stream.Open(id, v1::FRAME_MODE_LATEST));
  constexpr uint64_t kFrames = 3 * kLatestInFlight;
  std::thread sender([&stream] {
    for (uint64_t number = 0; number < kFrames; ++number) stream.Frame(number);
    stream.CloseSending();
  });
  for (uint64_t number = 0; number < kFrames; ++number) {
    ASSERT_TRUE(stream.Read());
    EXPECT_EQ(stream.reply.frame().sequence_number(), number);
  }
  sender.join();
  EXPECT_EQ(stream.reply.frame().outcome(), v1::OUTCOME_FITTED) << "the last one always is";
  EXPECT_EQ(stream.End(), grpc::StatusCode::OK);
}

TEST(FitFramesCallTest, AModeThatIsNotKnownIsRefused) {
  TestService service;
  RawStream stream(&service);
  EXPECT_FALSE(stream.Open(service.CreateSession(), static_cast<v1::FrameMode>(7)));
  EXPECT_EQ(stream.End(), grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_EQ(stream.detail().field(), "open.mode");
}

// ---- Deadlines ----

TEST(FitFramesCallTest, ADeadlineEndsTheStreamByThatNameAndConsumesNothing) {
  TestService service;
  const std::string id = service.CreateSession();
  RawStream stream(&service, absl::Seconds(1));
  ASSERT_TRUE(stream.Open(id));
  {
    const HeldFits held(&service, id);
    stream.Frame(0);
    EXPECT_EQ(stream.End(), grpc::StatusCode::DEADLINE_EXCEEDED);
    // What the server itself says: the client would say the same for any cancelled call.
    WaitFor([&service] { return !service.log->last_formatted().empty(); });
    EXPECT_THAT(service.log->last_formatted().front(), ::testing::HasSubstr("code=DEADLINE_EXCEEDED "));
  }
  service.WaitForFits(id);
  EXPECT_EQ((*service.store.Find(id))->Facts().next_sequence_number, 0u);
}

}  // namespace
}  // namespace cagefit::server
