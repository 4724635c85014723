#include "server/metrics_port.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <sstream>

#include "absl/strings/numbers.h"
#include "tests/server/http_get.h"
#include "tests/server/running_server.h"

namespace cagefit::server {
namespace {

using testing::CageRequest;
using testing::FitMovingFrames;
using ::testing::HasSubstr;
using ::testing::Not;
using testing::OutgoingMovingFrame;
using testing::ReceiveFrame;
using testing::RunningServer;

// Values by name and labels, as in `cagefit_frames_total{outcome="fitted"}`.
std::map<std::string, double> Scrape(const std::string& address) {
  std::map<std::string, double> values;
  std::istringstream lines(testing::HttpGet(address, "/metrics"));
  for (std::string line; std::getline(lines, line);) {
    const size_t space = line.rfind(' ');
    double value = 0;
    if (line.empty() || line[0] == '#' || space == std::string::npos) continue;
    if (absl::SimpleAtod(line.substr(space + 1), &value)) values[line.substr(0, space)] = value;
  }
  return values;
}

ServerOptions WithMetrics() {
  ServerOptions options;
  options.metrics_listen = "127.0.0.1:0";
  return options;
}

TEST(MetricsPortTest, CountsWhatAServerDoes) {
  RunningServer server(WithMetrics());
  const std::string address = server->metrics_address().value();
  const auto client = server.Connect();
  v1::CreateSessionRequest request = CageRequest();
  request.set_name("a name of a rig");
  const auto session = client->CreateSession(request);
  client->CreateSession(request).value();
  const auto stream = client->OpenStream(session->session_id());
  FitMovingFrames(stream->get(), 0, 3);
  client::OutgoingFrame broken;
  broken.sequence_number = 3;
  broken.draco = "not Draco";
  ASSERT_EQ((*stream)->Send(broken), absl::OkStatus());
  EXPECT_FALSE(ReceiveFrame(stream->get()).status.ok());
  ASSERT_EQ((*stream)->Send(OutgoingMovingFrame(1)), absl::OkStatus());
  EXPECT_TRUE(ReceiveFrame(stream->get()).reply.repeated_reply());
  EXPECT_FALSE(client->GetSession("nobody").ok());

  auto values = Scrape(address);
  EXPECT_EQ(values["cagefit_sessions"], 2);
  EXPECT_EQ(values["cagefit_streams"], 1);
  EXPECT_EQ(values["cagefit_ready"], 1);
  EXPECT_EQ(values["cagefit_frames_total{outcome=\"fitted\"}"], 3);
  EXPECT_EQ(values["cagefit_frames_total{outcome=\"rejected\"}"], 1);
  EXPECT_EQ(values["cagefit_frames_total{outcome=\"repeated\"}"], 1);
  EXPECT_EQ(values["cagefit_frame_verdicts_total{verdict=\"ok\"}"] +
                values["cagefit_frame_verdicts_total{verdict=\"suspect\"}"] +
                values["cagefit_frame_verdicts_total{verdict=\"lost\"}"],
            3);
  EXPECT_EQ(values["cagefit_rejects_total{reason=\"BAD_FRAME\"}"], 1);
  EXPECT_EQ(values["cagefit_rejects_total{reason=\"NO_SESSION\"}"], 1);
  EXPECT_EQ(values["cagefit_frame_stage_seconds_count{stage=\"decode\"}"], 4);
  for (const char* stage : {"queue", "decode", "index", "solve", "measure", "encode"}) {
    const std::string label = std::string("{stage=\"") + stage + "\"";
    EXPECT_GE(values["cagefit_frame_stage_seconds_count" + label + "}"], 3) << stage;
    EXPECT_EQ(values["cagefit_frame_stage_seconds_count" + label + "}"],
              values["cagefit_frame_stage_seconds_bucket" + label + ",le=\"+Inf\"}"]);
  }
  EXPECT_GT(values["cagefit_frame_stage_seconds_sum{stage=\"solve\"}"], 0);
  EXPECT_EQ(values["cagefit_frame_stage_seconds_count{stage=\"template\"}"], 1);
  for (const char* pool : {"queries", "decodes", "fits"}) {
    EXPECT_EQ(values.count(std::string("cagefit_queue_depth{pool=\"") + pool + "\"}"), 1u) << pool;
  }
  EXPECT_EQ(values.count("cagefit_in_flight_bytes"), 1u);
  EXPECT_EQ(values.count("cagefit_store_seconds_count"), 1u);
  EXPECT_GT(values["process_resident_memory_bytes"], 1e6);
  EXPECT_GT(values["cagefit_uptime_seconds"], 0);

  const std::string text = testing::HttpGet(address, "/metrics");
  EXPECT_THAT(text, HasSubstr("cagefit_build_info{"));
  EXPECT_THAT(text, HasSubstr("instruction_set=\""));
  EXPECT_THAT(text, Not(HasSubstr(session->session_id())));
  EXPECT_THAT(text, Not(HasSubstr("a name of a rig")));
}

TEST(MetricsPortTest, TellsThatAServerIsAboutToDrain) {
  RunningServer server(WithMetrics());
  server->StopBeingReady();
  EXPECT_EQ(Scrape(server->metrics_address().value())["cagefit_ready"], 0);
}

TEST(MetricsPortTest, IsNotThereUnlessAskedFor) {
  RunningServer server;
  EXPECT_EQ(server->metrics_address(), std::nullopt);
}

TEST(MetricsPortTest, NamesAnAddressThatIsTakenOrNone) {
  RunningServer server(WithMetrics());
  ServerOptions options;
  options.listen = {"127.0.0.1:0"};
  options.metrics_listen = server->metrics_address().value();
  const auto taken = Server::Start(options, SilentLog());
  EXPECT_TRUE(absl::IsUnavailable(taken.status())) << taken.status();
  EXPECT_THAT(std::string(taken.status().message()), HasSubstr(options.metrics_listen));
  for (const char* bad : {"9090", ":9090", "127.0.0.1", "127.0.0.1:", "127.0.0.1:9090s",
                          "nobody.invalid:1", "127.0.0.1:99999", "127.0.0.1:1,127.0.0.1:2"}) {
    options.metrics_listen = bad;
    const auto server_at_bad = Server::Start(options, SilentLog());
    EXPECT_FALSE(server_at_bad.ok()) << bad;
    EXPECT_THAT(std::string(server_at_bad.status().message()), HasSubstr(bad));
  }
}

}  // namespace
}  // namespace cagefit::server
