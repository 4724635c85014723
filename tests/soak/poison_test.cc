// A frame that kills the server, with a store that survives it.
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <memory>

#include "client/fit_client.h"
#include "client/status_from_grpc.h"
#include "tests/soak/sequence.h"
#include "tests/soak/soak_server.h"
#include "tests/soak/verdict.h"

namespace cagefit::testing {
namespace {

constexpr uint64_t kPoison = 2;

class PoisonTest : public ::testing::Test {
 protected:
  void SetUp() override {
    setenv("CAGEFITD_FAIL_POINTS", "session.before_fit=kill@#2", /*overwrite=*/1);
    ASSERT_EQ(server_.Start(), absl::OkStatus());
  }
  ~PoisonTest() override { unsetenv("CAGEFITD_FAIL_POINTS"); }

  // Streams frames on behind what is answered, one at a time, until the stream breaks or `frames`
  // are answered.
  std::vector<client::FittedFrame> Stream(const std::string& session_id, uint64_t frames) {
    const auto client = client::FitClient::Connect({server_.address()}).value();
    const auto stream = client->OpenStream(session_id).value();
    std::vector<client::FittedFrame> answers;
    for (uint64_t number = stream->next_sequence_number(); number < frames; ++number) {
      if (!stream->Send(SoakFrame(number)).ok()) break;
      auto answer = stream->Receive();
      if (!answer.ok() || !answer->has_value()) break;
      answers.push_back(**std::move(answer));
    }
    return answers;
  }

  const std::string folder_ = EmptyFolder("store");
  SoakServer server_{ProgramBeside("cagefitd_faults"),
                     {"--store", "sqlite:" + folder_ + "/sessions.db"}};
};

TEST_F(PoisonTest, IsAnsweredAfterThreeTriesAndTheStreamGoesOn) {
  const std::string id = client::FitClient::Connect({server_.address()})
                             .value()
                             ->CreateSession(SoakSession())
                             ->session_id();
  EXPECT_EQ(Stream(id, 5).size(), kPoison);
  for (int death = 1; death < 3; ++death) {
    ASSERT_EQ(server_.Start(), absl::OkStatus());
    EXPECT_TRUE(Stream(id, 5).empty());
  }
  ASSERT_EQ(server_.Start(), absl::OkStatus());
  const auto answers = Stream(id, 5);
  ASSERT_EQ(answers.size(), 3u);
  EXPECT_EQ(answers[0].reply.sequence_number(), kPoison);
  EXPECT_TRUE(absl::IsInternal(answers[0].status)) << answers[0].status;
  EXPECT_EQ(answers[0].reply.error().detail().reason(), "POISON_FRAME");
  EXPECT_EQ(answers[1].status, absl::OkStatus());
  EXPECT_EQ(answers[2].status, absl::OkStatus());
}

}  // namespace
}  // namespace cagefit::testing
