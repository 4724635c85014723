// A whole sequence through a server on a TCP socket, the client on the same cores.
#include <benchmark/benchmark.h>

#include <thread>

#include "client/fit_client.h"
#include "client/mesh_from_proto.h"
#include "server/log.h"
#include "server/server.h"
#include "tests/bench/scenes.h"

namespace cagefit::bench {
namespace {

// Sends every frame of the scene to a new session; false when one was not fitted.
bool StreamAll(client::FitClient* client, const Scene& scene) {
  v1::CreateSessionRequest request;
  *request.mutable_control_mesh() = client::ToProto(scene.cage);
  const auto session = client->CreateSession(request);
  if (!session.ok()) return false;
  auto stream = client->OpenStream(session->session_id());
  if (!stream.ok()) return false;
  std::thread sender([&] {
    for (size_t k = 0; k < scene.frames.size(); ++k) {
      client::OutgoingFrame frame;
      frame.draco = scene.frames[k];
      frame.sequence_number = k;
      if (!(*stream)->Send(frame).ok()) return;
    }
    (*stream)->CloseSending().IgnoreError();
  });
  size_t fitted = 0;
  while (true) {
    const auto frame = (*stream)->Receive();
    if (!frame.ok() || !frame->has_value()) break;
    fitted += (*frame)->status.ok();
  }
  sender.join();
  return fitted == scene.frames.size() && client->DeleteSession(session->session_id()).ok();
}

void FramesOverTheWire(benchmark::State& state) {
  const Scene& scene = Sequence();
  server::ServerOptions options;
  options.listen = {"127.0.0.1:0"};
  const auto server = server::Server::Start(options, server::SilentLog());
  if (!server.ok()) return state.SkipWithError("no server");
  const auto client = client::FitClient::Connect({(*server)->addresses()[0]});
  if (!client.ok()) return state.SkipWithError("no client");
  for (auto _ : state) {
    if (!StreamAll(client->get(), scene)) return state.SkipWithError("a frame was not fitted");
  }
  state.counters["frames_per_second"] = benchmark::Counter(
      static_cast<double>(scene.frames.size()), benchmark::Counter::kIsIterationInvariantRate);
  state.SetLabel(scene.label);
}
BENCHMARK(FramesOverTheWire)->Unit(benchmark::kMillisecond)->UseRealTime()->Iterations(1);

}  // namespace
}  // namespace cagefit::bench
