// Clients that go on, against the real server.
#include <gtest/gtest.h>

#include <thread>

#include "absl/strings/str_cat.h"
#include "client/resuming_stream.h"
#include "tests/server/running_server.h"
#include "tests/support/fault_proxy.h"

namespace cagefit::server {
namespace {

using cagefit::testing::Fault;
using cagefit::testing::FaultProxy;
using cagefit::testing::RandomPlan;
using client::FittedFrame;
using client::ResumingStream;
using testing::CageRequest;
using testing::FitMovingFrames;
using testing::OutgoingMovingFrame;
using testing::RunningServer;

constexpr uint64_t kFrames = 8;

client::ResumeOptions Soon() {
  client::ResumeOptions options;
  options.retry.first_pause = absl::Milliseconds(1);
  options.retry.longest_pause = absl::Milliseconds(20);
  return options;
}

// All frames through a stream on `client`, and how it ended.
absl::Status FitAll(client::FitClient* client, const std::string& id,
                    std::vector<FittedFrame>* frames) {
  ResumingStream stream(client, id, Soon());
  if (absl::Status opened = stream.Open(); !opened.ok()) return opened;
  std::thread sender([&stream] {
    for (uint64_t number = 0; number < kFrames; ++number) {
      if (!stream.Send(OutgoingMovingFrame(number)).ok()) return;
    }
    stream.CloseSending().IgnoreError();
  });
  absl::Status end;
  while (true) {
    auto frame = stream.Receive();
    end = frame.status();
    if (!frame.ok() || !frame->has_value()) break;
    frames->push_back(**std::move(frame));
  }
  stream.Cancel();
  sender.join();
  return end;
}

TEST(ResumingTest, ConnectionsThatAreCutAtAnyByteChangeNoBitOfTheSequence) {
  RunningServer server;
  const auto direct = server.Connect();
  const auto undisturbed = direct->OpenStream(direct->CreateSession(CageRequest())->session_id());
  const auto expected = FitMovingFrames(undisturbed->get(), 0, kFrames);
  const auto most_bytes = static_cast<int64_t>(3 * OutgoingMovingFrame(0).draco.size());
  uint64_t cuts = 0;
  for (uint32_t seed = 0; seed < 30; ++seed) {
    SCOPED_TRACE(absl::StrCat("seed ", seed));
    FaultProxy proxy(server.tcp(), [=](uint64_t connection) {
      return RandomPlan(seed % 2 == 0 ? Fault::kReset : Fault::kTruncate, seed, connection,
                        most_bytes);
    });
    const std::string id = direct->CreateSession(CageRequest())->session_id();
    // Connecting may be cut, too.
    auto client = client::FitClient::Connect({proxy.address(), absl::Seconds(30)});
    ASSERT_TRUE(client.ok()) << client.status();
    std::vector<FittedFrame> frames;
    ASSERT_EQ(FitAll(client->get(), id, &frames), absl::OkStatus());
    ASSERT_EQ(frames.size(), kFrames);
    for (uint64_t number = 0; number < kFrames; ++number) {
      EXPECT_EQ(frames[number].reply.sequence_number(), number);
      EXPECT_EQ(frames[number].control_vertices, expected[number].control_vertices) << number;
    }
    EXPECT_EQ(direct->GetSession(id)->next_sequence_number(), kFrames);
    cuts += proxy.faults();
  }
  EXPECT_GT(cuts, 30u);  // every sequence met some
}

TEST(ResumingTest, OfTwoStreamsOnOneSessionTheOlderEndsForGood) {
  RunningServer server;
  const auto client = server.Connect();
  const std::string id = client->CreateSession(CageRequest())->session_id();
  ResumingStream older(client.get(), id, Soon()), newer(client.get(), id, Soon());
  ASSERT_TRUE(older.Open().ok());
  ASSERT_TRUE(newer.Open().ok());
  EXPECT_EQ(testing::ReasonOf(older.Receive().status()), "EPOCH_SUPERSEDED");
  ASSERT_TRUE(newer.Send(OutgoingMovingFrame(0)).ok());
  EXPECT_TRUE(newer.Receive().ok());
  EXPECT_EQ(client->GetSession(id)->epoch(), 2u);
}

TEST(ResumingTest, AFrameAboveALimitEndsTheStreamSoon) {
  ServerOptions options;
  options.max_frame_mib = 1;
  RunningServer server(options);
  const auto client = server.Connect();
  ResumingStream stream(client.get(), client->CreateSession(CageRequest())->session_id(), Soon());
  ASSERT_TRUE(stream.Open().ok());
  client::OutgoingFrame frame;
  frame.draco.assign((1 << 20) + 1, 'x');
  ASSERT_TRUE(stream.Send(frame).ok());
  const absl::Status status = stream.Receive().status();
  EXPECT_TRUE(absl::IsResourceExhausted(status)) << status;
  EXPECT_EQ(client::DetailOf(status)->field(), "header.total_bytes");
}

TEST(ResumingTest, StoredRepliesHaveTheBitsOfTheStreamFromAnyFrameOn) {
  RunningServer server;
  const auto client = server.Connect();
  const std::string id = client->CreateSession(CageRequest())->session_id();
  const auto stream = client->OpenStream(id);
  const auto expected = FitMovingFrames(stream->get(), 0, kFrames);
  for (uint64_t first = 0; first <= kFrames; ++first) {
    v1::GetRepliesRequest request;
    request.set_session_id(id);
    request.set_first(first);
    uint64_t number = first;
    const absl::Status status = client->GetReplies(request, [&](FittedFrame frame) {
      EXPECT_EQ(frame.reply.sequence_number(), number);
      EXPECT_EQ(frame.control_vertices, expected[number].control_vertices);
      ++number;
      return absl::OkStatus();
    });
    EXPECT_EQ(status, absl::OkStatus());
    EXPECT_EQ(number, kFrames);
  }
}

TEST(ResumingTest, WhoTakesStoredRepliesMayEndTheCall) {
  RunningServer server;
  const auto client = server.Connect();
  const std::string id = client->CreateSession(CageRequest())->session_id();
  const auto stream = client->OpenStream(id);
  FitMovingFrames(stream->get(), 0, 3);
  v1::GetRepliesRequest request;
  request.set_session_id(id);
  int taken = 0;
  const absl::Status status = client->GetReplies(request, [&](FittedFrame) {
    ++taken;
    return absl::CancelledError("enough");
  });
  EXPECT_EQ(status, absl::CancelledError("enough"));
  EXPECT_EQ(taken, 1);
}

}  // namespace
}  // namespace cagefit::server
