// What a server's log says of calls and frames.
#include <gmock/gmock.h>
#include <grpcpp/grpcpp.h>
#include <gtest/gtest.h>
#include <spdlog/sinks/ostream_sink.h>

#include <nlohmann/json.hpp>
#include <sstream>

#include "cagefit/v1/fitting.grpc.pb.h"
#include "server/log_format.h"
#include "tests/server/running_server.h"

namespace cagefit::server {
namespace {

using nlohmann::json;
using testing::CageRequest;
using testing::FitMovingFrames;
using testing::ReceiveFrame;
using testing::RunningServer;

constexpr char kTraceId[] = "4bf92f3577b34da6a3ce929d0e0e4736";
constexpr char kTraceparent[] = "00-4bf92f3577b34da6a3ce929d0e0e4736-00f067aa0ba902b7-01";

class CallLogTest : public ::testing::Test {
 protected:
  CallLogTest() {
    auto log = std::make_shared<spdlog::logger>(
        "test", std::make_shared<spdlog::sinks::ostream_sink_mt>(out_));
    log->set_formatter(MakeFormatter(JsonLine));
    log->set_level(spdlog::level::debug);
    server_.emplace(ServerOptions(), log);
    stub_ = v1::Fitting::NewStub(
        grpc::CreateChannel(server_->tcp(), grpc::InsecureChannelCredentials()));
  }

  grpc::StatusCode GetSession(const std::string& id, const std::vector<std::string>& traceparents) {
    grpc::ClientContext context;
    for (const std::string& value : traceparents) context.AddMetadata("traceparent", value);
    v1::GetSessionRequest request;
    v1::Session session;
    request.set_session_id(id);
    return stub_->GetSession(&context, request, &session).error_code();
  }

  // The lines of an event, once the server has ended.
  std::vector<json> Lines(const std::string& event) {
    if (server_.has_value()) (*server_)->Shutdown(absl::Seconds(30));
    std::vector<json> lines;
    std::istringstream text(out_.str());
    for (std::string line; std::getline(text, line);) {
      json parsed = json::parse(line);
      if (parsed["event"] == event) lines.push_back(std::move(parsed));
    }
    return lines;
  }

  std::ostringstream out_;
  std::optional<RunningServer> server_;
  std::unique_ptr<v1::Fitting::Stub> stub_;
};

TEST_F(CallLogTest, AFinishedCallIsALineAtDebug) {
  const auto session = server_->Connect()->CreateSession(CageRequest());
  const auto lines = Lines("call");
  ASSERT_EQ(lines.size(), 1u);
  EXPECT_EQ(lines[0]["method"], "CreateSession");
  EXPECT_EQ(lines[0]["level"], "debug");
  EXPECT_EQ(lines[0]["code"], "OK");
  EXPECT_GE(lines[0]["ms"], 0.0);
  EXPECT_EQ(lines[0].count("reason"), 0u);
  EXPECT_THAT(lines[0]["peer"].get<std::string>(), ::testing::StartsWith("unix:"));
}

TEST_F(CallLogTest, AFailureSaysWhyWhateverTheClientSent) {
  const std::string hostile = "x\n\"} level=error \x1b[31m";
  EXPECT_EQ(GetSession(hostile, {}), grpc::StatusCode::NOT_FOUND);
  const auto lines = Lines("call");
  ASSERT_EQ(lines.size(), 1u);
  EXPECT_EQ(lines[0]["level"], "info");
  EXPECT_EQ(lines[0]["code"], "NOT_FOUND");
  EXPECT_EQ(lines[0]["reason"], "NO_SESSION");
  EXPECT_THAT(lines[0]["message"].get<std::string>(), ::testing::HasSubstr(hostile));
}

TEST_F(CallLogTest, EveryLineOfACallHasTheTraceIdOfItsCaller) {
  const auto session = server_->Connect()->CreateSession(CageRequest());
  grpc::ClientContext context;
  context.AddMetadata("traceparent", kTraceparent);
  const auto stream = stub_->FitFrames(&context);
  v1::FitFramesRequest request;
  v1::FitFramesReply reply;
  request.mutable_open()->set_session_id(session->session_id());
  ASSERT_TRUE(stream->Write(request) && stream->Read(&reply));
  const std::string draco = testing::OutgoingMovingFrame(0).draco;
  request.mutable_header()->set_total_bytes(draco.size());
  ASSERT_TRUE(stream->Write(request));
  request.mutable_chunk()->set_data(draco);
  ASSERT_TRUE(stream->Write(request) && stream->Read(&reply));
  stream->WritesDone();
  ASSERT_TRUE(stream->Finish().ok());

  const auto frames = Lines("frame");
  ASSERT_EQ(frames.size(), 1u);
  EXPECT_EQ(frames[0]["trace_id"], kTraceId);
  EXPECT_EQ(frames[0]["session"], session->session_id());
  EXPECT_EQ(frames[0]["frame"], 0);
  EXPECT_EQ(frames[0]["outcome"], "fitted");
  EXPECT_GT(frames[0]["points"], 0);
  const auto calls = Lines("call");
  ASSERT_EQ(calls.size(), 2u);
  EXPECT_EQ(calls[1]["method"], "FitFrames");
  EXPECT_EQ(calls[1]["trace_id"], kTraceId);
  EXPECT_EQ(calls[1]["session"], session->session_id());
  EXPECT_EQ(calls[1]["level"], "info");
}

TEST_F(CallLogTest, WithoutAGoodTraceparentACallHasAnIdOfItsOwn) {
  GetSession("a", {});
  GetSession("b", {"00-nonsense-00f067aa0ba902b7-01"});
  GetSession("c", {kTraceparent, kTraceparent});
  GetSession("d", {kTraceparent});
  std::vector<std::string> ids;
  for (const json& line : Lines("call")) ids.push_back(line["trace_id"]);
  ASSERT_EQ(ids.size(), 4u);
  EXPECT_EQ(ids[3], kTraceId);
  for (int k = 0; k < 3; ++k) {
    EXPECT_THAT(ids[k], ::testing::MatchesRegex("[0-9a-f]+"));
    EXPECT_EQ(ids[k].size(), 32u);
    for (int other = k + 1; other < 4; ++other) EXPECT_NE(ids[k], ids[other]);
  }
}

TEST_F(CallLogTest, ARejectedFrameIsAWarning) {
  const auto client = server_->Connect();
  const auto stream = client->OpenStream(client->CreateSession(CageRequest())->session_id());
  client::OutgoingFrame broken;
  broken.draco = "not Draco";
  ASSERT_EQ((*stream)->Send(broken), absl::OkStatus());
  ReceiveFrame(stream->get());
  const auto frames = Lines("frame");
  ASSERT_EQ(frames.size(), 1u);
  EXPECT_EQ(frames[0]["level"], "warning");
  EXPECT_EQ(frames[0]["outcome"], "rejected");
  EXPECT_EQ(frames[0]["code"], "INVALID_ARGUMENT");
  EXPECT_NE(frames[0]["error"], "");
}

}  // namespace
}  // namespace cagefit::server
