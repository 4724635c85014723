// A rig's own program: stream_clouds HOST:PORT. Streams the clouds of a ball that grows, and prints
// what comes back for each.
#include <cmath>
#include <cstdlib>
#include <iostream>
#include <thread>

#include "client/fit_client.h"
#include "client/resuming_stream.h"
#include "core/codec/draco_codec.h"

namespace {

using cagefit::client::FitClient;
using cagefit::client::ResumingStream;

constexpr int kFrames = 5, kPoints = 20'000;

// What a camera would give: points spread over a ball of some radius, and their normals.
cagefit::PointCloud Capture(double radius) {
  cagefit::PointCloud cloud;
  cloud.normals.resize(3, kPoints);
  for (int k = 0; k < kPoints; ++k) {  // a spiral from pole to pole
    const double z = 1 - (2 * k + 1.0) / kPoints, around = 2.399963 * k, r = std::sqrt(1 - z * z);
    cloud.normals.col(k) =
        Eigen::Vector3d(r * std::cos(around), r * std::sin(around), z).cast<float>();
  }
  cloud.points = static_cast<float>(radius) * cloud.normals;
  return cloud;
}

// On a thread of its own, as frames come from the cameras. Frames are kept until they are answered:
// when the connection breaks, or the server starts again, they are sent again.
void SendFrames(ResumingStream* stream) {
  for (int k = 0; k < kFrames; ++k) {
    cagefit::client::OutgoingFrame frame;
    frame.sequence_number = k;
    frame.draco = cagefit::EncodeDracoCloud(Capture(1 + 0.05 * k), {}).value();
    if (!stream->Send(std::move(frame)).ok()) return;  // Receive says why
  }
  stream->CloseSending().IgnoreError();
}

absl::Status Fit(const std::string& address) {
  const auto client = FitClient::Connect({address});
  if (!client.ok()) return client.status();
  cagefit::v1::CreateSessionRequest request;
  request.set_name("example");
  request.mutable_make_template()->set_vertices(200);  // from the first frame
  const auto session = (*client)->CreateSession(request);
  if (!session.ok()) return session.status();

  ResumingStream stream(client->get(), session->session_id());
  if (const absl::Status opened = stream.Open(); !opened.ok()) return opened;
  std::thread sender(SendFrames, &stream);
  absl::Status status;
  while (true) {
    const auto frame = stream.Receive();
    status = frame.status();
    if (!status.ok() || !frame->has_value()) break;
    const cagefit::client::FittedFrame& fitted = **frame;
    std::cout << "frame " << fitted.reply.sequence_number() << ": ";
    if (fitted.status.ok()) {
      std::cout << fitted.control_vertices.cols() << " control vertices, RMS "
                << fitted.reply.distances().rms_percent() << " %\n";
    } else {
      std::cout << fitted.status.message() << "\n";
    }
  }
  if (!status.ok()) stream.Cancel();  // the sender may wait for room
  sender.join();
  return status.ok() ? (*client)->DeleteSession(session->session_id()) : status;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::cerr << "usage: stream_clouds HOST:PORT\n";
    return 2;
  }
  const absl::Status status = Fit(argv[1]);
  if (!status.ok()) std::cerr << "stream_clouds: " << status.message() << "\n";
  return status.ok() ? EXIT_SUCCESS : EXIT_FAILURE;
}
