// A server on a real socket, and captures for it.
#ifndef CAGEFIT_TESTS_SERVER_RUNNING_SERVER_H_
#define CAGEFIT_TESTS_SERVER_RUNNING_SERVER_H_

#include <grpc/grpc.h>
#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "client/fit_client.h"
#include "client/mesh_from_proto.h"
#include "client/status_from_grpc.h"
#include "core/base/private_folder.h"
#include "server/log.h"
#include "server/server.h"
#include "tests/support/frames.h"

namespace cagefit::server::testing {

// Listens on a free port of this machine and on a Unix socket.
class RunningServer {
 public:
  explicit RunningServer(ServerOptions options = ServerOptions(),
                         std::shared_ptr<spdlog::logger> log = SilentLog()) {
    // Without a reference of its own, the next test would wait for gRPC to shut down first: 10 s
    // after large messages.
    static const bool keep_grpc = (grpc_init(), true);
    (void)keep_grpc;
    options.listen = {"127.0.0.1:0", "unix:" + folder_.path() + "/socket"};
    auto server = Server::Start(options, std::move(log));
    EXPECT_TRUE(server.ok()) << server.status();
    server_ = *std::move(server);
  }

  Server* operator->() const { return server_.get(); }
  const std::string& tcp() const { return server_->addresses()[0]; }
  const std::string& unix_socket() const { return server_->addresses()[1]; }
  std::unique_ptr<client::FitClient> Connect() const {
    return client::FitClient::Connect({unix_socket()}).value();
  }

 private:
  PrivateFolder folder_ = PrivateFolder::Create().value();
  std::unique_ptr<Server> server_;
};

inline v1::CreateSessionRequest CageRequest(int levels = 1) {
  v1::CreateSessionRequest request;
  *request.mutable_control_mesh() = client::ToProto(cagefit::testing::FrameCage(levels));
  return request;
}

inline client::OutgoingFrame OutgoingMovingFrame(uint64_t number) {
  client::OutgoingFrame frame;
  frame.sequence_number = number;
  frame.draco =
      cagefit::testing::FrameBytes(cagefit::testing::MovingCloud(static_cast<int>(number)));
  return frame;
}

inline std::string ReasonOf(const absl::Status& status) {
  const auto detail = client::DetailOf(status);
  return detail.has_value() ? detail->reason() : "";
}

// The next answer, which must come.
inline client::FittedFrame ReceiveFrame(client::FrameStream* stream) {
  auto frame = stream->Receive();
  EXPECT_TRUE(frame.ok()) << frame.status();
  if (!frame.ok() || !frame->has_value()) {
    ADD_FAILURE() << "no answer";
    return {};
  }
  return **std::move(frame);
}

// Sends frames [begin, end) of the moving sequence and returns their answers.
inline std::vector<client::FittedFrame> FitMovingFrames(client::FrameStream* stream, uint64_t begin,
                                                        uint64_t end) {
  std::thread sender([stream, begin, end] {
    for (uint64_t number = begin; number < end; ++number) {
      const absl::Status sent = stream->Send(OutgoingMovingFrame(number));
      if (!sent.ok()) {
        ADD_FAILURE() << sent;
        return;
      }
    }
  });
  std::vector<client::FittedFrame> frames;
  for (uint64_t number = begin; number < end; ++number) frames.push_back(ReceiveFrame(stream));
  sender.join();
  return frames;
}

}  // namespace cagefit::server::testing

#endif  // CAGEFIT_TESTS_SERVER_RUNNING_SERVER_H_
