#include "server/server_options.h"

#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdlib>
#include <iostream>
#include <memory>
#include <set>
#include <utility>

#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_replace.h"
#include "absl/strings/str_split.h"
#include "core/base/status.h"

namespace cagefit::server {
namespace {

constexpr char kVariablePrefix[] = "CAGEFITD_";
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

std::unique_ptr<CLI::App> MakeApp(ServerOptions* o) {
  o->store = DefaultStore();
  auto app = std::make_unique<CLI::App>(
      "Fits subdivision surfaces to streams of point clouds: the Cagefit server.", "cagefitd");
  app->set_version_flag("--version", "cagefitd " CAGEFIT_VERSION);
  app->set_config("--config", "", "File of settings, one name=value a line");
  app->allow_config_extras(CLI::config_extras_mode::error);
  app->footer(
      "Every option is also read from CAGEFITD_NAME, as in CAGEFITD_MAX_POINTS (lists separated by "
      "commas).\nA flag counts more than a variable, a variable more than the file.");
  app->add_option("--listen", o->listen, "HOST:PORT (port 0: any free one) or unix:PATH; repeat")
      ->capture_default_str();
  app->add_option("--store", o->store, "Where sessions are kept: memory, or sqlite:PATH")
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
  app->add_option("--threads", o->threads, "Threads of all fits together; 0: one per core")
      ->capture_default_str();
  app->add_option("--fits", o->fits, "Concurrent fits; 0: half the threads")->capture_default_str();
  app->add_option("--drain-seconds", o->drain_seconds, "For frames in work on SIGTERM")
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

// Variables of ours that are set, as the flags that they stand for; `given` are left out. Returns
// the name of one that no option has.
std::optional<std::string> AddVariables(const CLI::App& app, const std::set<std::string>& given,
                                        std::vector<std::string>* arguments) {
  for (char** entry = environ; *entry != nullptr; ++entry) {
    if (!absl::StartsWith(*entry, kVariablePrefix)) continue;
    const std::pair<std::string, std::string> variable =
        absl::StrSplit(*entry, absl::MaxSplits('=', 1));
    const std::string flag =
        "--" + absl::StrReplaceAll(
                   absl::AsciiStrToLower(variable.first.substr(sizeof(kVariablePrefix) - 1)),
                   {{"_", "-"}});
    const CLI::Option* option = app.get_option_no_throw(flag);
    if (option == nullptr || flag == "--help" || flag == "--version") return variable.first;
    if (given.count(flag) > 0) continue;
    const bool list = option->get_items_expected_max() > 1;
    for (absl::string_view value :
         absl::StrSplit(variable.second, absl::MaxSplits(',', list ? 1000 : 0))) {
      arguments->push_back(absl::StrCat(flag, "=", value));
    }
  }
  return std::nullopt;
}

std::string Suggestion(const CLI::App& app, const std::string& variable) {
  // The one that shares the longest beginning.
  std::string best;
  size_t longest = sizeof(kVariablePrefix) - 1;
  for (const CLI::Option* option : app.get_options()) {
    const std::string name = kVariablePrefix + absl::AsciiStrToUpper(absl::StrReplaceAll(
                                                   option->get_single_name(), {{"-", "_"}}));
    const size_t common = static_cast<size_t>(
        std::mismatch(name.begin(), name.end(), variable.begin(), variable.end()).first -
        name.begin());
    if (common > longest) {
      longest = common;
      best = name;
    }
  }
  return best.empty() ? "" : absl::StrCat("; did you mean ", best, "?");
}

// CLI11 takes its arguments from the back.
void Parse(CLI::App& app, std::vector<std::string> arguments) {
  std::reverse(arguments.begin(), arguments.end());
  app.parse(std::move(arguments));
}

// The long names of options on the command line.
std::set<std::string> GivenFlags(const std::vector<std::string>& arguments) {
  std::set<std::string> given;
  for (const std::string& argument : arguments) {
    given.insert(argument.substr(0, argument.find('=')));
  }
  return given;
}

int Fail(const std::string& message) {
  std::cerr << "cagefitd: " << message << "\nRun cagefitd --help for the options.\n";
  return kWrongUsage;
}

}  // namespace

absl::Status ServerOptions::Validate() const {
  if (listen.empty()) return absl::InvalidArgumentError("--listen is empty; expected an address");
  if (store != "memory" && !(absl::StartsWith(store, "sqlite:") && store.size() > 7)) {
    return absl::InvalidArgumentError(
        absl::StrCat("--store is ", store, "; expected memory or sqlite:PATH"));
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
  RETURN_IF_ERROR(CheckRange("threads", threads, 0, 1024));
  RETURN_IF_ERROR(CheckRange("fits", fits, 0, 1024));
  RETURN_IF_ERROR(CheckRange("drain-seconds", drain_seconds, 0, 3600));
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

ParsedServerOptions ParseServerOptions(int argc, const char* const* argv) {
  ParsedServerOptions parsed;
  const std::unique_ptr<CLI::App> app = MakeApp(&parsed.options);
  std::vector<std::string> arguments(argv + 1, argv + argc);
  // CLI11 itself would let a file overrule a variable, so variables go in as flags.
  const std::optional<std::string> unknown = AddVariables(*app, GivenFlags(arguments), &arguments);
  if (unknown.has_value()) {
    parsed.exit_code =
        Fail(absl::StrCat("no setting is called ", *unknown, Suggestion(*app, *unknown)));
    return parsed;
  }
  try {
    Parse(*app, std::move(arguments));
  } catch (const CLI::Success& success) {
    parsed.exit_code = app->exit(success);
    return parsed;
  } catch (const CLI::ParseError& error) {
    parsed.exit_code = Fail(error.what());
    return parsed;
  }
  const absl::Status valid = parsed.options.Validate();
  if (!valid.ok()) parsed.exit_code = Fail(std::string(valid.message()));
  return parsed;
}

}  // namespace cagefit::server
