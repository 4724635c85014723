#include "server/server_options.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdlib>
#include <iostream>
#include <memory>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "core/base/status.h"
#include "server/server_options_print.h"
#include "server/server_options_sources.h"
#include "server/server_options_suggestion.h"
#include "server/store/open_journal.h"

namespace cagefit::server {
namespace {

constexpr int kWrongUsage = 2;

constexpr std::array<const char*, 6> kLogLevels = {"trace",   "debug", "info",
                                                   "warning", "error", "off"};

absl::Status CheckRange(const char* field, double value, double least, double most) {
  if (value >= least && value <= most) return absl::OkStatus();  // false for NaN
  return absl::InvalidArgumentError(
      absl::StrFormat("--%s is %.12g; expected %.12g to %.12g", field, value, least, most));
}

absl::Status CheckTls(const ServerOptions& o) {
  if (o.tls_cert.empty() != o.tls_key.empty()) {
    return absl::InvalidArgumentError(
        o.tls_key.empty() ? "--tls-key is not set; --tls-cert needs the certificate's key"
                          : "--tls-cert is not set; --tls-key needs the key's certificate");
  }
  if (!o.tls_client_ca.empty() && o.tls_cert.empty()) {
    return absl::InvalidArgumentError(
        "--tls-cert is not set; --tls-client-ca needs TLS, and so --tls-cert and --tls-key");
  }
  return absl::OkStatus();
}

// The first argument that looks like an option and is none.
absl::Status UnknownOption(const CLI::App& app, const std::vector<std::string>& arguments) {
  std::vector<std::string> names;
  for (const CLI::Option* option : app.get_options()) {
    names.push_back("--" + option->get_single_name());
  }
  for (const std::string& argument : arguments) {
    const std::string name = argument.substr(0, argument.find('='));
    if (!absl::StartsWith(name, "-") || app.get_option_no_throw(name) != nullptr) continue;
    return absl::InvalidArgumentError(
        absl::StrCat("no option is called ", name, Suggestion(name, names)));
  }
  return absl::OkStatus();
}

// `exit_code` is set after --help and --version.
absl::Status Parse(CLI::App& app, const CommandLine& line, std::optional<int>* exit_code) {
  try {
    // CLI11 takes its arguments from the back.
    app.parse(std::vector<std::string>(line.arguments.rbegin(), line.arguments.rend()));
  } catch (const CLI::Success& success) {
    *exit_code = app.exit(success);
  } catch (const CLI::ExtrasError& error) {
    RETURN_IF_ERROR(UnknownOption(app, line.arguments));
    return absl::InvalidArgumentError(error.what());
  } catch (const CLI::ParseError& error) {
    return absl::InvalidArgumentError(error.what());
  }
  return absl::OkStatus();
}

int Fail(const std::string& message) {
  std::cerr << "cagefitd: " << message << "\nRun cagefitd --help for the options.\n";
  return kWrongUsage;
}

}  // namespace

absl::Status ServerOptions::Validate() const {
  if (listen.empty()) return absl::InvalidArgumentError("--listen is empty; expected an address");
  if (const absl::Status named = CheckStoreName(store); !named.ok()) {
    return absl::InvalidArgumentError(absl::StrCat("--", named.message()));
  }
  RETURN_IF_ERROR(CheckRange("session-ttl-seconds", session_ttl_seconds, 0, 1e9));
  RETURN_IF_ERROR(CheckRange("template-memory-mib", template_memory_mib, 64, 1 << 20));
  RETURN_IF_ERROR(CheckRange("template-seconds", template_seconds, 1, 86'400));
  RETURN_IF_ERROR(CheckRange("max-frame-mib", max_frame_mib, 1, 1024));
  RETURN_IF_ERROR(CheckRange("max-points", max_points, 16, 100e6));
  RETURN_IF_ERROR(CheckRange("max-control-vertices", max_control_vertices, 4, 200'000));
  RETURN_IF_ERROR(CheckRange("max-sessions", max_sessions, 1, 1e6));
  RETURN_IF_ERROR(CheckRange("max-frames", max_frames, 1, 1e9));
  RETURN_IF_ERROR(CheckRange("max-history-mib", max_history_mib, 1, 1 << 20));
  RETURN_IF_ERROR(CheckRange("max-streams", max_streams, 1, 1e6));
  RETURN_IF_ERROR(CheckRange("max-buffered-mib", max_buffered_mib, 1, 1 << 20));
  if (max_memory_mib != 0) RETURN_IF_ERROR(CheckRange("max-memory", max_memory_mib, 256, 1 << 20));
  RETURN_IF_ERROR(CheckRange("threads", threads, 0, 1024));
  RETURN_IF_ERROR(CheckRange("fits", fits, 0, 1024));
  RETURN_IF_ERROR(CheckRange("drain-seconds", drain_seconds, 0, 3600));
  RETURN_IF_ERROR(CheckRange("drain-delay", drain_delay, 0, 3600));
  if (log_format != "text" && log_format != "json") {
    return absl::InvalidArgumentError(
        absl::StrCat("--log-format is ", log_format, "; expected text or json"));
  }
  if (std::find(kLogLevels.begin(), kLogLevels.end(), log_level) == kLogLevels.end()) {
    return absl::InvalidArgumentError(
        absl::StrCat("--log-level is ", log_level, "; expected ", absl::StrJoin(kLogLevels, ", ")));
  }
  return CheckTls(*this);
}

std::string DefaultStore() {
  const auto variable = [](const char* name) {
    const char* value = std::getenv(name);
    return std::string(value == nullptr ? "" : value);
  };
  std::string folder = "/var/lib/cagefit";
  if (const std::string state = variable("STATE_DIRECTORY"); !state.empty()) {
    folder = state;
  } else if (const std::string xdg = variable("XDG_STATE_HOME"); !xdg.empty()) {
    folder = absl::StrCat(xdg, "/cagefit");
  } else if (const std::string home = variable("HOME"); geteuid() != 0 && !home.empty()) {
    folder = absl::StrCat(home, "/.local/state/cagefit");
  }
  return absl::StrCat("sqlite:", folder, "/sessions.db");
}

std::unique_ptr<CLI::App> MakeApp(ServerOptions* o) {
  o->store = DefaultStore();
  auto app = std::make_unique<CLI::App>(
      "Fits subdivision surfaces to streams of point clouds: the Cagefit server.", "cagefitd");
  app->set_version_flag("--version", "cagefitd " CAGEFIT_VERSION);
  app->add_option_function<std::string>(
      "--config", [](const std::string&) {}, "File of settings, one name=value a line");
  app->add_flag("--print-config", "Print the settings in force, as --config reads them, and end");
  app->footer(
      "Every option is also read from CAGEFITD_NAME, as in CAGEFITD_MAX_POINTS (lists separated by "
      "commas).\nA flag counts more than a variable, a variable more than the file.");
  app->add_option("--listen", o->listen, "HOST:PORT (port 0: any free one) or unix:PATH; repeat")
      ->capture_default_str();
  app->add_option("--store", o->store, absl::StrCat("Where sessions are kept: ", kStores))
      ->capture_default_str();
  app->add_option("--session-ttl-seconds", o->session_ttl_seconds,
                  "Sessions that nobody uses for so long are deleted; 0: never")
      ->capture_default_str();
  app->add_option("--template-program", o->template_program,
                  "Program that makes templates; default: cagefit beside this one");
  app->add_option("--template-memory-mib", o->template_memory_mib, "Its limit of memory")
      ->capture_default_str();
  app->add_option("--template-seconds", o->template_seconds, "Its limit of time")
      ->capture_default_str();
  app->add_option("--max-frame-mib", o->max_frame_mib, "Encoded size of a frame")
      ->capture_default_str();
  app->add_option("--max-points", o->max_points, "Points of a frame")->capture_default_str();
  app->add_option("--max-control-vertices", o->max_control_vertices, "Of a control mesh")
      ->capture_default_str();
  app->add_option("--max-sessions", o->max_sessions, "Sessions at a time")->capture_default_str();
  app->add_option("--max-frames", o->max_frames, "Frames of a session")->capture_default_str();
  app->add_option("--max-history-mib", o->max_history_mib, "Stored replies of a session")
      ->capture_default_str();
  app->add_option("--max-streams", o->max_streams, "Open streams")->capture_default_str();
  app->add_option("--max-buffered-mib", o->max_buffered_mib,
                  "In flight of all calls: unanswered frames, unsent results")
      ->capture_default_str();
  app->add_option("--max-memory", o->max_memory_mib,
                  "MiB of the process; 0: 80 % of what the machine or the container has")
      ->capture_default_str();
  app->add_option("--threads", o->threads, "Threads of all fits together; 0: one per core")
      ->capture_default_str();
  app->add_option("--fits", o->fits, "Concurrent fits; 0: half the threads")->capture_default_str();
  app->add_option("--drain-seconds", o->drain_seconds, "For frames in work on SIGTERM")
      ->capture_default_str();
  app->add_option("--drain-delay", o->drain_delay,
                  "Seconds from not being ready to that, for load balancers to notice")
      ->capture_default_str();
  app->add_option("--health-listen", o->health_listen,
                  "Address of health alone, without TLS, as probes need it; default: none");
  app->add_option("--metrics-listen", o->metrics_listen,
                  "HOST:PORT of metrics for Prometheus, at /metrics; default: none");
  app->add_option("--log-format", o->log_format, "Lines of the log: text, json")
      ->capture_default_str();
  app->add_option("--log-level", o->log_level, "trace, debug, info, warning, error, off")
      ->capture_default_str();
  app->add_option("--tls-cert", o->tls_cert, "Certificates of the TCP addresses, PEM file");
  app->add_option("--tls-key", o->tls_key, "Their key, PEM file");
  app->add_option("--tls-client-ca", o->tls_client_ca,
                  "Clients need a certificate of one of these authorities, PEM file");
  app->add_option("--tokens", o->tokens, "Clients need a token of this file; see cagefit token");
  app->add_flag("--reflection", o->reflection, "Tell clients the service's methods and messages");
  return app;
}

ParsedServerOptions ParseServerOptions(int argc, const char* const* argv) {
  ParsedServerOptions parsed;
  const std::unique_ptr<CLI::App> app = MakeApp(&parsed.options);
  CommandLine line({argv + 1, argv + argc});
  absl::Status status = AddEnvironment(*app, &line);
  if (status.ok()) status = AddFile(*app, &line);
  if (status.ok()) status = Parse(*app, line, &parsed.exit_code);
  if (status.ok() && !parsed.exit_code.has_value()) status = parsed.options.Validate();
  if (!status.ok()) {
    parsed.exit_code = Fail(std::string(status.message()));
  } else if (!parsed.exit_code.has_value() && app->count("--print-config") > 0) {
    std::cout << SettingsText(*app, line);
    parsed.exit_code = EXIT_SUCCESS;
  }
  return parsed;
}

}  // namespace cagefit::server
