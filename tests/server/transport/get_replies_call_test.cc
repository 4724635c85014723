#include "server/transport/get_replies_call.h"

#include <gtest/gtest.h>

#include <vector>

#include "tests/server/transport/service_fixture.h"

namespace cagefit::server {
namespace {

using testing::BoundedContext;
using testing::DecodedFrame;
using testing::MovingFrame;
using testing::ServiceLimits;
using testing::TestService;

constexpr uint64_t kRejected = 2;

// A session with five answers, the third one a rejection.
std::string SessionWithAnswers(TestService* service) {
  const std::string id = service->CreateSession();
  const auto ledger = *service->store.Find(id);
  const uint64_t epoch = ledger->OpenStream([](const absl::Status&) {}).value()->epoch;
  auto lease = service->store.Lease(id);
  for (uint64_t number = 0; number < 5; ++number) {
    Frame frame = number == kRejected ? DecodedFrame(number, "not Draco") : MovingFrame(number);
    EXPECT_TRUE((*lease)->Answer(std::move(frame), epoch, nullptr).ok());
  }
  return id;
}

v1::GetRepliesRequest From(const std::string& id, uint64_t first) {
  v1::GetRepliesRequest request;
  request.set_session_id(id);
  request.set_first(first);
  return request;
}

struct Replies {
  std::vector<v1::FrameReply> messages;
  grpc::StatusCode code = grpc::StatusCode::UNKNOWN;
  v1::ErrorDetail detail;
};

Replies Get(TestService* service, const v1::GetRepliesRequest& request) {
  BoundedContext context;
  const auto reader = service->stub->GetReplies(&context, request);
  Replies replies;
  v1::FrameReply reply;
  while (reader->Read(&reply)) replies.messages.push_back(reply);
  replies.code = reader->Finish().error_code();
  replies.detail = testing::DetailOf(context);
  return replies;
}

TEST(GetRepliesCallTest, BringsEveryReplyInOrder) {
  TestService service;
  const Replies replies = Get(&service, From(SessionWithAnswers(&service), 0));
  ASSERT_EQ(replies.code, grpc::StatusCode::OK);
  ASSERT_EQ(replies.messages.size(), 5u);
  for (uint64_t number = 0; number < 5; ++number) {
    EXPECT_EQ(replies.messages[number].sequence_number(), number);
    EXPECT_TRUE(replies.messages[number].repeated_reply());
  }
  EXPECT_EQ(replies.messages[kRejected].outcome(), v1::OUTCOME_REJECTED);
  EXPECT_EQ(replies.messages[kRejected].error().detail().reason(), "BAD_FRAME");
  EXPECT_TRUE(replies.messages[0].delta().key());
  EXPECT_FALSE(replies.messages[4].delta().key());
}

TEST(GetRepliesCallTest, BeginsWithAKeyFrameWhereverItBegins) {
  TestService service;
  const std::string id = SessionWithAnswers(&service);
  const Replies from_fitted = Get(&service, From(id, 1));
  ASSERT_EQ(from_fitted.messages.size(), 4u);
  EXPECT_TRUE(from_fitted.messages[0].delta().key());
  EXPECT_FALSE(from_fitted.messages[2].delta().key());
  const Replies from_rejected = Get(&service, From(id, kRejected));
  ASSERT_EQ(from_rejected.messages.size(), 3u);
  EXPECT_TRUE(from_rejected.messages[1].delta().key()) << "the first fitted one";
  EXPECT_FALSE(from_rejected.messages[2].delta().key());
}

TEST(GetRepliesCallTest, EndsAfterTheCount) {
  TestService service;
  v1::GetRepliesRequest request = From(SessionWithAnswers(&service), 1);
  for (const auto& [count, expected] : {std::pair(2ul, 2u), {0ul, 0u}, {~0ul, 4u}}) {
    request.set_count(count);
    const Replies replies = Get(&service, request);
    EXPECT_EQ(replies.code, grpc::StatusCode::OK);
    EXPECT_EQ(replies.messages.size(), expected);
  }
}

TEST(GetRepliesCallTest, NothingYetIsNoError) {
  TestService service;
  const Replies replies = Get(&service, From(service.CreateSession(), 0));
  EXPECT_EQ(replies.code, grpc::StatusCode::OK);
  EXPECT_TRUE(replies.messages.empty());
}

TEST(GetRepliesCallTest, AFirstFrameBeyondTheLastIsOutOfRange) {
  TestService service;
  const Replies replies = Get(&service, From(SessionWithAnswers(&service), 6));
  EXPECT_EQ(replies.code, grpc::StatusCode::OUT_OF_RANGE);
  EXPECT_EQ(replies.detail.field(), "first");
  EXPECT_EQ(replies.detail.value(), "6");
  EXPECT_EQ(replies.detail.limit(), "5");
}

TEST(GetRepliesCallTest, AnUnknownSessionIsNotFound) {
  TestService service;
  EXPECT_EQ(Get(&service, From("nobody", 0)).code, grpc::StatusCode::NOT_FOUND);
}

TEST(GetRepliesCallTest, AnExhaustedBudgetOrQueueEndsIt) {
  ServiceLimits limits;
  limits.budget_bytes = 10;
  TestService poor(limits);
  EXPECT_EQ(Get(&poor, From(SessionWithAnswers(&poor), 0)).code,
            grpc::StatusCode::RESOURCE_EXHAUSTED);
  EXPECT_EQ(poor.budget.taken(), 0);
  limits.budget_bytes = 1 << 20;
  limits.scheduler.max_queued = 0;
  TestService busy(limits);
  EXPECT_EQ(Get(&busy, From(SessionWithAnswers(&busy), 0)).code,
            grpc::StatusCode::RESOURCE_EXHAUSTED);
}

TEST(GetRepliesCallTest, AReaderThatLeavesDoesNotHoldTheServer) {
  TestService service;
  const std::string id = SessionWithAnswers(&service);
  BoundedContext context;
  const auto reader = service.stub->GetReplies(&context, From(id, 0));
  v1::FrameReply reply;
  ASSERT_TRUE(reader->Read(&reply));
  context.TryCancel();
  while (reader->Read(&reply)) {
  }
  const grpc::StatusCode code = reader->Finish().error_code();
  EXPECT_TRUE(code == grpc::StatusCode::CANCELLED || code == grpc::StatusCode::OK) << code;
}

}  // namespace
}  // namespace cagefit::server
