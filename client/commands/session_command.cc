#include <iostream>
#include <memory>
#include <optional>
#include <string>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "client/commands/command.h"
#include "client/commands/credential_flags.h"
#include "client/commands/message_json.h"
#include "client/commands/pull_frames.h"
#include "client/commands/sequence_formats.h"
#include "client/fit_client.h"
#include "client/io/file_bytes.h"
#include "client/io/geometry_file.h"
#include "core/base/status.h"
#include "core/codec/draco_codec.h"

namespace cagefit::client {
namespace {

struct SessionArguments {
  std::string server = "127.0.0.1:50051", id, out, frames;
  ClientCredentials credentials;
  SequenceFormats formats;
  std::optional<uint64_t> frame;
  bool json = false, surface = false, start = false;
  uint32_t levels = 2;
};

using Work = absl::Status (*)(FitClient* client, const SessionArguments& arguments);

absl::Status List(FitClient* client, const SessionArguments& arguments) {
  ASSIGN_OR_RETURN(const std::vector<v1::Session> sessions, client->ListSessions());
  if (arguments.json) {
    Json json = Json::array();
    for (const v1::Session& session : sessions) json.push_back(ToJson(session));
    std::cout << Text(json, 2) << "\n";
    return absl::OkStatus();
  }
  std::cout << absl::StreamFormat("%-34s %8s %9s %9s  %s\n", "session", "fitted", "rejected",
                                  "vertices", "name");
  for (const v1::Session& s : sessions) {
    std::cout << absl::StreamFormat("%-34s %8d %9d %9d  %s%s\n", s.session_id(), s.fitted_frames(),
                                    s.rejected_frames(), s.control_vertices(), s.name(),
                                    s.stream_attached() ? " (streaming)" : "");
  }
  return absl::OkStatus();
}

absl::Status Show(FitClient* client, const SessionArguments& arguments) {
  ASSIGN_OR_RETURN(const v1::Session session, client->GetSession(arguments.id));
  std::cout << Text(ToJson(session), 2) << "\n";
  return absl::OkStatus();
}

absl::Status Delete(FitClient* client, const SessionArguments& arguments) {
  return client->DeleteSession(arguments.id);
}

absl::Status PullSurface(FitClient* client, const SessionArguments& arguments) {
  v1::GetSurfaceRequest request;
  request.set_session_id(arguments.id);
  if (arguments.frame.has_value()) request.set_sequence_number(*arguments.frame);
  request.set_levels(arguments.levels);
  ASSIGN_OR_RETURN(const std::string draco, client->GetSurface(request));
  if (FileExtension(arguments.out) == ".drc") return WriteFileBytes(arguments.out, draco);
  ASSIGN_OR_RETURN(const TriangleMesh mesh, DecodeDracoMesh(draco, DecodeLimits()));
  return WriteMesh(arguments.out, mesh);
}

absl::Status Pull(FitClient* client, const SessionArguments& arguments) {
  if (!arguments.frames.empty()) {
    return PullFrames(client, arguments.id, arguments.frames, arguments.formats);
  }
  if (arguments.surface) return PullSurface(client, arguments);
  v1::GetControlMeshRequest request;
  request.set_session_id(arguments.id);
  if (arguments.start) request.set_template_(true);
  if (arguments.frame.has_value()) request.set_sequence_number(*arguments.frame);
  ASSIGN_OR_RETURN(const ControlMesh mesh, client->GetControlMesh(request));
  return WriteControlMesh(arguments.out, mesh);
}

int WithClient(const SessionArguments& arguments, Work work) {
  ClientOptions options;
  options.address = arguments.server;
  options.credentials = arguments.credentials;
  const auto client = FitClient::Connect(options);
  if (!client.ok()) return Report(client.status());
  const absl::Status status = work(client->get(), arguments);
  return status.ok() ? static_cast<int>(kDone) : Report(status);
}

}  // namespace

void AddSessionCommand(CLI::App* app, Run* run) {
  const auto arguments = std::make_shared<SessionArguments>();
  CLI::App* command =
      app->add_subcommand("session", "List, show, delete or pull a server's sessions");
  command->require_subcommand(1);
  const auto add = [&](const char* name, const char* what, Work work) {
    CLI::App* sub = command->add_subcommand(name, what);
    sub->add_option("--server", arguments->server, "HOST:PORT or unix:PATH")->capture_default_str();
    AddCredentialFlags(&arguments->credentials, sub);
    sub->callback([arguments, run, work] {
      *run = [arguments, work] { return WithClient(*arguments, work); };
    });
    return sub;
  };
  const auto add_with_id = [&](const char* name, const char* what, Work work) {
    CLI::App* sub = add(name, what, work);
    sub->add_option("SESSION", arguments->id, "Its id, as `list` shows it")->required();
    return sub;
  };
  add("list", "List all sessions", &List)->add_flag("--json", arguments->json, "Print JSON");
  add_with_id("show", "Show a session and its options as JSON", &Show);
  add_with_id("delete", "Delete a session and what it stores", &Delete);
  CLI::App* pull = add_with_id(
      "pull",
      "Write a session's control mesh, or its surface, to a file, or all of its frames to a "
      "folder",
      &Pull);
  CLI::Option* out = pull->add_option("--out", arguments->out, "File to write");
  CLI::Option* frames = pull->add_option("--frames", arguments->frames,
                                         "Folder to write to: NNNN.obj of every fitted frame, by "
                                         "its sequence number, and report.json")
                            ->excludes(out);
  CLI::Option* frame =
      pull->add_option("--frame", arguments->frame, "Sequence number; default: the latest")
          ->excludes(frames);
  CLI::Option* start =
      pull->add_flag("--template", arguments->start, "The mesh that the session started from")
          ->excludes(frame)
          ->excludes(frames);
  pull->add_flag("--surface", arguments->surface, "The refined limit surface")
      ->excludes(start)
      ->excludes(frames);
  AddFormatFlags(&arguments->formats, pull)->needs(frames);
  pull->parse_complete_callback([out, frames] {
    if (*out || *frames) return;
    throw CLI::RequiredError("--out FILE or --frames FOLDER");
  });
  pull->add_option("--levels", arguments->levels, "Refinement levels of the surface")
      ->capture_default_str();
}

}  // namespace cagefit::client
