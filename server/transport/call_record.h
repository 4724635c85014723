// What is kept of a call until it ends, to be told once: a line in the log, and a count when it
// failed.
#ifndef CAGEFIT_SERVER_TRANSPORT_CALL_RECORD_H_
#define CAGEFIT_SERVER_TRANSPORT_CALL_RECORD_H_

#include <grpcpp/server_context.h>
#include <grpcpp/support/status.h>

#include <string>

#include "absl/status/status.h"
#include "server/transport/service_state.h"

namespace cagefit::server {

class CallRecord {
 public:
  // Begins with the call. `state` and `context` must live until End.
  CallRecord(const ServiceState& state, grpc::CallbackServerContext* context, const char* method);

  const std::string& trace_id() const { return trace_id_; }
  void SetSession(const std::string& session_id) { session_id_ = session_id; }

  // What to finish the call with. Call it once, right before. Faults and overload are told at
  // warning, other failures and the ends of streams of frames, which have a session, at info, the
  // rest at debug.
  grpc::Status End(const absl::Status& status);

 private:
  void Log(const absl::Status& status) const;

  const ServiceState& state_;
  grpc::CallbackServerContext* const context_;
  const char* const method_;
  const std::string trace_id_;
  const double start_ms_;
  std::string session_id_;
};

}  // namespace cagefit::server

#endif  // CAGEFIT_SERVER_TRANSPORT_CALL_RECORD_H_
