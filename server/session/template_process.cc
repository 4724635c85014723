#include "server/session/template_process.h"

#include <signal.h>
#include <unistd.h>

#include <fstream>
#include <sstream>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/strip.h"
#include "core/base/private_folder.h"
#include "core/base/status.h"
#include "server/session/error_detail.h"
#include "server/session/obj_reader.h"

namespace cagefit::server {
namespace {

constexpr int kWorkFailed = 1;   // exit code of a frame that gives no template
constexpr int kWrongUsage = 2;   // a program without templates, or none of ours
constexpr int kCannotRun = 126;  // and above: it was never started

absl::Status WriteFile(const std::string& path, absl::string_view bytes) {
  std::ofstream file(path, std::ios::binary);
  file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  file.close();
  if (!file) return absl::UnavailableError(absl::StrCat(path, ": cannot be written"));
  return absl::OkStatus();
}

std::string ReadFile(const std::string& path) {
  std::ostringstream text;
  text << std::ifstream(path, std::ios::binary).rdbuf();
  return text.str();
}

absl::Status ToStatus(const ChildResult& result, const ChildLimits& limits,
                      const std::string& program) {
  if (result.exit_code == 0) return absl::OkStatus();
  const std::string end =
      absl::StrCat(result.exit_code >= 0 ? absl::StrCat("exit code ", result.exit_code)
                                         : absl::StrCat("signal ", result.signal, ", memory limit ",
                                                        limits.max_memory_bytes >> 20, " MiB"),
                   ": ", absl::StripSuffix(result.last_stderr, "\n"));
  if (result.exit_code == kWorkFailed) {
    return WithDetail(
        absl::InvalidArgumentError(absl::StrCat("no template from this frame, ", end)),
        {"TEMPLATE_FAILED", "make_template", "", ""});
  }
  if (result.exit_code == kWrongUsage || result.exit_code >= kCannotRun) {
    return WithDetail(absl::FailedPreconditionError(
                          absl::StrCat("the template program ", program, " does not work, ", end)),
                      {"TEMPLATE_PROGRAM_MISSING", "make_template", program, ""});
  }
  if (result.signal == SIGXCPU || result.signal == SIGKILL) {
    return WithDetail(
        absl::ResourceExhaustedError(absl::StrCat("the template program was stopped, ", end)),
        {"LIMIT_EXCEEDED", "template program", absl::StrCat("signal ", result.signal), ""});
  }
  return WithDetail(absl::InternalError(absl::StrCat("the template program broke down, ", end)),
                    {"TEMPLATE_FAILED", "make_template", "", ""});
}

}  // namespace

TemplateProcess::TemplateProcess(std::string program, const ChildLimits& limits)
    : program_(std::move(program)), limits_(limits) {}

absl::Status TemplateProcess::CheckAvailable() const {
  if (access(program_.c_str(), X_OK) == 0) return absl::OkStatus();
  return WithDetail(
      absl::FailedPreconditionError(absl::StrCat(
          "make_template needs the program \"", program_,
          "\", which is not there: install cagefit with templates beside the server or name it "
          "with --template-program, or send a control mesh made by `cagefit template`")),
      {"TEMPLATE_PROGRAM_MISSING", "make_template", program_, ""});
}

absl::StatusOr<ControlMesh> TemplateProcess::Make(absl::string_view draco,
                                                  const TemplateRequest& request,
                                                  const CancelFn& cancelled) {
  RETURN_IF_ERROR(CheckAvailable());
  ASSIGN_OR_RETURN(const PrivateFolder folder, PrivateFolder::Create());
  const std::string input = absl::StrCat(folder.path(), "/frame.drc");
  const std::string output = absl::StrCat(folder.path(), "/cage.obj");
  RETURN_IF_ERROR(WriteFile(input, draco));
  std::vector<std::string> command = {
      program_, "template", input, "--vertices", absl::StrCat(request.vertices), "--out", output};
  if (request.crease_angle_degrees.has_value()) {
    command.insert(command.end(), {"--crease-angle", absl::StrCat(*request.crease_angle_degrees)});
  }
  ASSIGN_OR_RETURN(const ChildResult result, RunChild(command, limits_, cancelled));
  RETURN_IF_ERROR(ToStatus(result, limits_, program_));
  // Within 1 % of the request, by the program's contract; the bound only has to stop nonsense.
  auto mesh = ReadTemplateObj(ReadFile(output), 2 * request.vertices);
  if (mesh.ok()) return mesh;
  return WithDetail(
      absl::InternalError(absl::StrCat("the template program's output: ", mesh.status().message())),
      {"TEMPLATE_FAILED", "make_template", "", ""});
}

}  // namespace cagefit::server
