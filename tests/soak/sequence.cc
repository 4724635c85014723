#include "tests/soak/sequence.h"

#include <utility>

#include "client/embedded_server.h"
#include "client/mesh_from_proto.h"
#include "core/base/status.h"
#include "tests/soak/resume.h"
#include "tests/support/frames.h"
#include "tests/support/history_checker.h"

namespace cagefit::testing {

v1::CreateSessionRequest SoakSession() {
  v1::CreateSessionRequest request;
  *request.mutable_control_mesh() = client::ToProto(FrameCage(0));
  request.mutable_options()->mutable_fit()->set_max_iterations(5);
  // Kills land between key frames, too.
  request.mutable_options()->set_key_interval(7);
  return request;
}

client::OutgoingFrame SoakFrame(uint64_t number) {
  constexpr int64_t kPoints = 200;
  client::OutgoingFrame frame;
  frame.sequence_number = number;
  frame.draco = FrameBytes(MovingCloud(static_cast<int>(number), kPoints));
  return frame;
}

absl::StatusOr<std::vector<std::string>> UndisturbedBits(uint64_t frames) {
  ASSIGN_OR_RETURN(const auto server, client::EmbeddedServer::Start());
  ASSIGN_OR_RETURN(const auto client, client::FitClient::Connect({server->address()}));
  ASSIGN_OR_RETURN(const v1::Session session, client->CreateSession(SoakSession()));
  std::vector<std::string> bits;
  Resumption run;
  run.address = server->address();
  run.session_id = session.session_id();
  run.frames = frames;
  run.seen = [&bits](const History::Event& event) {
    if (event.kind == History::Event::Kind::kAnswered) bits.push_back(event.bits);
  };
  RETURN_IF_ERROR(StreamToEnd(run));
  return bits;
}

}  // namespace cagefit::testing
