// All settings of the server: flags, a file, or CAGEFITD_... variables.
#ifndef CAGEFIT_SERVER_SERVER_OPTIONS_H_
#define CAGEFIT_SERVER_SERVER_OPTIONS_H_

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"

namespace CLI {
class App;
}

namespace cagefit::server {

struct ServerOptions {
  std::vector<std::string> listen = {"127.0.0.1:50051"};  // HOST:PORT, port 0: any; unix:PATH

  // Where sessions are kept: "memory", or "sqlite:PATH" for a file that survives the process. What
  // ParseServerOptions gives without a setting is a file in the user's folder of program data.
  std::string store = "memory";
  double session_ttl_seconds = 7 * 86'400;  // of sessions that nobody uses; 0: for ever, to 1e9

  // Templates are made by this program; empty: "cagefit" beside this one.
  std::string template_program;
  int64_t template_memory_mib = 8192;  // of its address space; 64 to 1,048,576
  double template_seconds = 120;       // 1 to 86,400

  // What is too much.
  int64_t max_frame_mib = 64;              // one encoded frame; 1 to 1,024
  int64_t max_points = 4'000'000;          // of a frame; 16 to 100,000,000
  int64_t max_control_vertices = 200'000;  // 4 to 200,000: a reply has to stay below 4 MiB
  int64_t max_sessions = 1'000;            // 1 to 1,000,000
  int64_t max_frames = 1'000'000;          // answered frames of a session; 1 to 1,000,000,000
  int64_t max_history_mib = 512;           // stored replies of a session; 1 to 1,048,576
  int64_t max_streams = 2'000;             // open at a time; 1 to 1,000,000
  int64_t max_buffered_mib = 2'048;        // in flight of all calls; 1 to 1,048,576
  // Of the process; 256 to 1,048,576 MiB. 0: 80 % of what the machine or the container has.
  int64_t max_memory_mib = 0;

  // How much is done at a time; 0: from the number of cores.
  int64_t threads = 0;  // of all fits together; 0 to 1,024
  int64_t fits = 0;     // concurrent ones; 0 to 1,024

  double drain_seconds = 20;   // for frames in work when the server is told to end; 0 to 3,600
  double drain_delay = 0;      // seconds between not being ready and that; 0 to 3,600
  std::string health_listen;   // as `listen`, for health alone, never encrypted; empty: nowhere
  std::string metrics_listen;  // HOST:PORT of metrics for Prometheus; empty: nowhere
  std::string log_format = "text";  // text, json
  std::string log_level = "info";   // trace, debug, info, warning, error, off

  // Who is let in. Files in PEM format and, of tokens, as in session/token_table.h; all of them are
  // read again when they change.
  std::string tls_cert, tls_key;  // of the TCP addresses, both or neither; empty: no TLS
  std::string tls_client_ca;      // clients need a certificate of these; empty: they do not
  std::string tokens;             // empty: nobody needs one
  bool reflection = false;        // tells anybody the service's methods and messages

  // INVALID_ARGUMENT naming field, value and range.
  absl::Status Validate() const;
};

// sqlite: and sessions.db in $STATE_DIRECTORY (which systemd sets), $XDG_STATE_HOME/cagefit,
// /var/lib/cagefit for root, or ~/.local/state/cagefit.
std::string DefaultStore();

// All options with their defaults; parsing writes `options`, which must outlive the result.
std::unique_ptr<CLI::App> MakeApp(ServerOptions* options);

struct ParsedServerOptions {
  ServerOptions options;
  std::optional<int> exit_code;  // set when there is nothing to run: --help, --version, or an error
};

// Flags over environment over file over default. Prints help, and what --print-config asks for, to
// stdout and errors to stderr.
ParsedServerOptions ParseServerOptions(int argc, const char* const* argv);

}  // namespace cagefit::server

#endif  // CAGEFIT_SERVER_SERVER_OPTIONS_H_
