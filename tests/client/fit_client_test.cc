#include "client/fit_client.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/private_folder.h"
#include "tests/client/fake_fitting.h"

namespace cagefit::client {
namespace {

TEST(FitClientTest, NamesAnAddressWhereNobodyAnswers) {
  const auto folder = PrivateFolder::Create();
  ASSERT_TRUE(folder.ok()) << folder.status();
  const std::string address = "unix:" + folder->path() + "/nobody";
  const auto client = FitClient::Connect({address, absl::Milliseconds(50)});
  EXPECT_TRUE(absl::IsUnavailable(client.status())) << client.status();
  EXPECT_THAT(std::string(client.status().message()), ::testing::HasSubstr(address));
}

// A service with the answers of five frames, the second of them rejected, and a client that asks
// for all of them.
class StoredRepliesTest : public ::testing::Test {
 protected:
  StoredRepliesTest() {
    const auto stream = client_->OpenStream("any").value();
    for (uint64_t k = 0; k < 5; ++k) {
      OutgoingFrame frame;
      frame.sequence_number = k;
      frame.draco = (k == 1 ? "bad" : "good") + std::to_string(k);
      EXPECT_TRUE(stream->Send(frame).ok());
      sent_.push_back(*stream->Receive().value());
    }
    retry_.first_pause = absl::Milliseconds(1);
  }

  absl::Status Get(std::optional<uint64_t> count = std::nullopt) {
    v1::GetRepliesRequest request;
    request.set_session_id("any");
    if (count.has_value()) request.set_count(*count);
    return client_->GetReplies(
        request,
        [this](FittedFrame frame) {
          got_.push_back(std::move(frame));
          return absl::OkStatus();
        },
        retry_);
  }
  void ExpectFirst(size_t count) const {
    ASSERT_EQ(got_.size(), count);
    for (size_t k = 0; k < count; ++k) {
      EXPECT_EQ(got_[k].reply.sequence_number(), k);
      EXPECT_EQ(got_[k].status, sent_[k].status);
      ASSERT_EQ(got_[k].control_vertices.cols(), sent_[k].control_vertices.cols());
      EXPECT_EQ(got_[k].control_vertices, sent_[k].control_vertices);
    }
  }

  std::function<grpc::Status(testing::Place)> breaks_;  // none while it is empty
  testing::FakeFitting service_{[this](testing::Place place, grpc::ServerContext*) {
    return breaks_ ? breaks_(place) : grpc::Status::OK;
  }};
  std::unique_ptr<FitClient> client_ = service_.Connect();
  std::vector<FittedFrame> sent_, got_;
  RetryOptions retry_;
};

TEST_F(StoredRepliesTest, ComeOnceInOrderWhereverTheCallBreaks) {
  for (const testing::Place place : {testing::Place::kBeforeReply, testing::Place::kAfterReply}) {
    for (int at = 0; at < 5; ++at) {
      int passed = 0;
      breaks_ = [&passed, place, at](testing::Place here) {
        return here == place && passed++ == at ? grpc::Status(grpc::StatusCode::UNAVAILABLE, "gone")
                                               : grpc::Status::OK;
      };
      got_.clear();
      EXPECT_EQ(Get(), absl::OkStatus());
      EXPECT_GT(passed, at);
      ExpectFirst(5);
    }
  }
}

TEST_F(StoredRepliesTest, NoMoreThanTheCountComeWhereTheCallBreaks) {
  int calls = 0;
  breaks_ = [&calls](testing::Place here) {
    if (here == testing::Place::kBeforeOpened) ++calls;
    return here == testing::Place::kAfterReply
               ? grpc::Status(grpc::StatusCode::UNAVAILABLE, "after each")
               : grpc::Status::OK;
  };
  EXPECT_EQ(Get(3), absl::OkStatus());
  ExpectFirst(3);
  EXPECT_EQ(calls, 3);  // and none for the end
}

TEST_F(StoredRepliesTest, EndWithWhatWillNotPassOrDoesNot) {
  breaks_ = [](testing::Place here) {
    return here == testing::Place::kBeforeOpened
               ? grpc::Status(grpc::StatusCode::NOT_FOUND, "no such session")
               : grpc::Status::OK;
  };
  EXPECT_TRUE(absl::IsNotFound(Get()));
  retry_.give_up_after = absl::Milliseconds(50);
  breaks_ = [](testing::Place) { return grpc::Status(grpc::StatusCode::UNAVAILABLE, "gone"); };
  EXPECT_TRUE(absl::IsUnavailable(Get()));
  ExpectFirst(0);
}

}  // namespace
}  // namespace cagefit::client
