// Requests that a server must refuse, and exactly what it must say.
#ifndef CAGEFIT_TESTS_SERVER_MALFORMED_MALFORMED_REQUEST_H_
#define CAGEFIT_TESTS_SERVER_MALFORMED_MALFORMED_REQUEST_H_

#include <functional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "cagefit/v1/fitting.grpc.pb.h"
#include "client/fit_client.h"

namespace cagefit::server::testing {

// A server to send to, with a session that has fitted frame 0.
struct Target {
  client::FitClient* client;
  v1::Fitting::Stub* stub;
  std::string session_id;
};

struct MalformedRequest {
  std::string name;  // what is wrong with it
  std::function<absl::Status(const Target&)> send;
  // What the server says: its status, or the error of the frame that it rejects.
  absl::StatusCode code = absl::StatusCode::kInvalidArgument;
  std::string reason, field, value;
  std::string message;  // is in the message
};

// By subject. Limits are those that Limits() sets.
std::vector<MalformedRequest> MalformedOptions();
std::vector<MalformedRequest> MalformedMeshes();
std::vector<MalformedRequest> MalformedCameras();
std::vector<MalformedRequest> MalformedStreams();
std::vector<MalformedRequest> MalformedFrames();
std::vector<MalformedRequest> MalformedQueries();

inline constexpr int64_t kMaxFrameMib = 2;
inline constexpr int64_t kMaxPoints = 2000;
inline constexpr int64_t kMaxControlVertices = 2562;

// What a FitFrames call that sends these messages and closes its side ends with, or the error of
// the first frame that it rejects.
absl::Status EndOfStream(const Target& target, const std::vector<v1::FitFramesRequest>& messages);
v1::FitFramesRequest Open(const std::string& session_id);
v1::FitFramesRequest Header(uint64_t number, uint64_t total_bytes);
v1::FitFramesRequest Chunk(const std::string& data);

}  // namespace cagefit::server::testing

#endif  // CAGEFIT_TESTS_SERVER_MALFORMED_MALFORMED_REQUEST_H_
