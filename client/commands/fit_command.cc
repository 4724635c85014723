#include <chrono>
#include <filesystem>
#include <iostream>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "client/camera_to_proto.h"
#include "client/commands/command.h"
#include "client/commands/fit_options.h"
#include "client/commands/fit_report.h"
#include "client/commands/input_files.h"
#include "client/commands/interrupt.h"
#include "client/commands/mask_files.h"
#include "client/commands/message_json.h"
#include "client/commands/progress.h"
#include "client/embedded_server.h"
#include "client/encode_frame.h"
#include "client/fit_client.h"
#include "client/io/camera_file.h"
#include "client/io/file_bytes.h"
#include "client/io/geometry_file.h"
#include "client/mesh_from_proto.h"
#include "core/base/status.h"

namespace cagefit::client {
namespace {

double Seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

absl::Status MakeFolder(const std::string& path) {
  std::error_code error;
  std::filesystem::create_directories(path, error);
  if (!error) return absl::OkStatus();
  return absl::FailedPreconditionError(absl::StrCat(path, ": cannot be made: ", error.message()));
}

// One `cagefit fit`: files in, one session, one stream, files out.
class FitJob {
 public:
  FitJob(const FitArguments& arguments, std::vector<std::string> files, Interrupt* interrupt)
      : arguments_(arguments), interrupt_(interrupt) {
    for (std::string& file : files) {
      report_.frames.emplace_back();
      report_.frames.back().file = std::move(file);
    }
  }

  // The report holds whatever came, even when this fails.
  absl::Status Run() {
    RETURN_IF_ERROR(MakeFolder(arguments_.out + "/frames"));
    ASSIGN_OR_RETURN(const v1::CreateSessionRequest request, SessionRequest());
    RETURN_IF_ERROR(Connect());
    ASSIGN_OR_RETURN(report_.session, client_->CreateSession(request));
    absl::Status streamed = Stream();
    // What the session says at the end: its options in force and its counts.
    auto session = client_->GetSession(report_.session.session_id());
    if (session.ok()) report_.session = *std::move(session);
    if (!arguments_.keep_session) {
      client_->DeleteSession(report_.session.session_id()).IgnoreError();
    }
    return streamed;
  }

  absl::Status Finish() {
    if (cage_.has_value() && !arguments_.quick && !interrupt_->seen()) {
      MeasureFrames(*cage_, &report_);
    }
    if (report_.diagonal == 0) report_.diagonal = SampledDiagonal();
    report_.settings = Settings();
    RETURN_IF_ERROR(WriteFileBytes(arguments_.out + "/report.json", ReportJson(report_).dump(2)));
    if (last_fitted_ == nullptr) return absl::OkStatus();
    return WriteControlMesh(arguments_.out + "/cage.obj",
                            cage_->WithVertices(last_fitted_->control_vertices));
  }

  const FitReport& report() const { return report_; }
  bool has_begun() const { return stream_ != nullptr; }

 private:
  absl::StatusOr<v1::CreateSessionRequest> SessionRequest() {
    v1::CreateSessionRequest request;
    request.set_name(
        (arguments_.name.empty() ? arguments_.inputs.front() : arguments_.name).substr(0, 200));
    *request.mutable_options() = arguments_.options;
    RETURN_IF_ERROR(AddCameras(request.mutable_options()));
    if (arguments_.cage.empty()) {
      request.mutable_make_template()->set_vertices(arguments_.vertices);
      if (arguments_.crease_angle.has_value()) {
        request.mutable_make_template()->set_crease_angle_degrees(*arguments_.crease_angle);
      }
      return request;
    }
    ASSIGN_OR_RETURN(cage_, ReadControlMesh(arguments_.cage));
    *request.mutable_control_mesh() = ToProto(*cage_);
    return request;
  }

  absl::Status AddCameras(v1::SessionOptions* options) {
    if (arguments_.cameras.empty()) return absl::OkStatus();
    ASSIGN_OR_RETURN(const std::vector<Camera> cameras, ReadCameras(arguments_.cameras));
    std::vector<std::string> names, files;
    for (const Camera& camera : cameras) {
      names.push_back(camera.name);
      *options->add_cameras() = client::ToProto(camera);
    }
    if (arguments_.masks.empty()) return absl::OkStatus();
    for (const FrameRecord& frame : report_.frames) files.push_back(frame.file);
    ASSIGN_OR_RETURN(masks_, ListMasks(arguments_.masks, names, files));
    return absl::OkStatus();
  }

  absl::Status Connect() {
    std::string address = arguments_.server;
    if (address.empty()) {
      ASSIGN_OR_RETURN(embedded_, EmbeddedServer::Start(arguments_.threads));
      address = embedded_->address();
    }
    ASSIGN_OR_RETURN(client_, FitClient::Connect({address}));
    return absl::OkStatus();
  }

  absl::Status Stream() {
    ASSIGN_OR_RETURN(stream_, client_->OpenStream(report_.session.session_id()));
    interrupt_->SetAction([this] { stream_->Cancel(); });
    const double start = Seconds();
    std::thread sender([this] { SendAll(); });
    absl::Status received = ReceiveAll();
    if (!received.ok()) stream_->Cancel();  // the sender may wait for room that nobody makes
    sender.join();
    interrupt_->SetAction(nullptr);
    report_.seconds = Seconds() - start;
    return received;
  }

  // On a thread of its own. A file that cannot be read is a refused frame and takes no number.
  void SendAll() {
    uint64_t number = 0;
    for (size_t k = 0; k < report_.frames.size() && !interrupt_->seen(); ++k) {
      FrameRecord& record = report_.frames[k];
      auto read = ReadFrame(k);
      if (!read.ok()) {
        record.status = absl::InvalidArgumentError(read.status().message());
        continue;
      }
      OutgoingFrame frame = *std::move(read);
      frame.sequence_number = number++;
      {
        std::lock_guard<std::mutex> lock(mutex_);
        file_of_number_.push_back(k);
      }
      if (!stream_->Send(frame).ok()) return;  // the stream has ended; the receiver knows why
    }
    stream_->CloseSending().IgnoreError();
  }

  absl::StatusOr<OutgoingFrame> ReadFrame(size_t index) const {
    OutgoingFrame frame;
    ASSIGN_OR_RETURN(frame.draco,
                     EncodeFrame(report_.frames[index].file, arguments_.position_bits));
    if (masks_.empty()) return frame;
    ASSIGN_OR_RETURN(frame.masks, ReadMasks(masks_[index]));
    return frame;
  }

  absl::Status ReceiveAll() {
    std::optional<Progress> progress;
    if (!arguments_.json) progress.emplace(report_.frames.size());
    size_t answered = 0;
    double first = 0;
    while (true) {
      ASSIGN_OR_RETURN(std::optional<FittedFrame> frame, stream_->Receive());
      if (!frame.has_value()) return absl::OkStatus();
      const size_t index = FileOfNumber(frame->reply.sequence_number());
      FrameRecord& record = report_.frames[index];
      RETURN_IF_ERROR(Take(*std::move(frame), index, &record));
      const double now = Seconds();
      if (answered++ == 0) first = now;
      if (answered > 1) report_.frames_per_second = (answered - 1) / (now - first);
      if (progress.has_value()) progress->Show(index + 1, Describe(record));
      if (arguments_.json) std::cout << FrameJson(record, index, 0).dump() << std::endl;
    }
  }

  size_t FileOfNumber(uint64_t number) {
    std::lock_guard<std::mutex> lock(mutex_);
    return file_of_number_.at(number);
  }

  absl::Status Take(FittedFrame frame, size_t index, FrameRecord* record) {
    record->status = frame.status;
    record->delta_bytes = static_cast<int64_t>(frame.reply.delta().ByteSizeLong());
    if (frame.status.ok()) {
      if (!cage_.has_value() || frame.reply.has_tolerance()) {  // which refines a given one
        ASSIGN_OR_RETURN(cage_, MadeTemplate(frame));
      }
      record->control_vertices = std::move(frame.control_vertices);
      last_fitted_ = record;
      RETURN_IF_ERROR(WriteControlMesh(absl::StrFormat("%s/frames/%04d.obj", arguments_.out, index),
                                       cage_->WithVertices(record->control_vertices)));
    }
    record->reply = std::move(frame.reply);
    record->reply.clear_delta();
    record->reply.clear_template_();
    return absl::OkStatus();
  }

  absl::StatusOr<ControlMesh> MadeTemplate(const FittedFrame& frame) {
    if (frame.reply.has_template_()) {
      v1::ControlMesh mesh = frame.reply.template_();
      mesh.mutable_vertices()->Assign(
          frame.control_vertices.data(),
          frame.control_vertices.data() + frame.control_vertices.size());
      return FromProto(mesh);
    }
    v1::GetControlMeshRequest request;
    request.set_session_id(report_.session.session_id());
    request.set_template_(true);
    return client_->GetControlMesh(request);
  }

  static std::string Describe(const FrameRecord& record) {
    if (!record.status.ok()) return absl::StrCat("refused: ", record.status.message());
    const v1::FrameReply& r = record.reply;
    return absl::StrFormat("RMS %.4f %%, %d steps, %.0f ms%s", r.distances().rms_percent(),
                           r.iterations(), r.milliseconds().index() + r.milliseconds().solve(),
                           r.verdict() == v1::VERDICT_LOST ? ", LOST" : "");
  }

  // The server's, from a distance that it gave both ways.
  double SampledDiagonal() const {
    for (const FrameRecord& frame : report_.frames) {
      const v1::SampledDistances& d = frame.reply.distances();
      if (frame.status.ok() && d.rms_percent() > 0) return 100 * d.rms() / d.rms_percent();
    }
    return 0;
  }

  Json Settings() const {
    return {{"inputs", arguments_.inputs},
            {"template", arguments_.cage},
            {"vertices", arguments_.vertices},
            {"crease_angle",
             arguments_.crease_angle.has_value() ? Json(*arguments_.crease_angle) : Json()},
            {"cameras", arguments_.cameras},
            {"masks", arguments_.masks},
            {"server", arguments_.server},
            {"position_bits", arguments_.position_bits},
            {"options", ToJson(report_.session.options())}};
  }

  const FitArguments& arguments_;
  Interrupt* interrupt_;
  std::unique_ptr<EmbeddedServer> embedded_;
  std::unique_ptr<FitClient> client_;
  std::unique_ptr<FrameStream> stream_;
  std::vector<std::vector<MaskFile>> masks_;  // of every frame, where there are any
  std::mutex mutex_;
  std::vector<size_t> file_of_number_;  // of every sequence number that was sent
  std::optional<ControlMesh> cage_;     // its connectivity is that of every frame
  const FrameRecord* last_fitted_ = nullptr;
  FitReport report_;
};

int ExitCodeOf(const FitReport& report) {
  const FitTotals totals = Totals(report);
  if (totals.fitted == 0) return kFailed;
  const bool all = totals.fitted == static_cast<int>(report.frames.size()) && totals.lost == 0 &&
                   !totals.beyond_tolerance;
  return all ? kDone : kPartlyDone;
}

// Says what went wrong and what is left of the work.
int ReportBrokenOff(const absl::Status& status, const FitReport& report, bool interrupted) {
  const int fitted = Totals(report).fitted;
  std::cerr << "cagefit: "
            << (interrupted ? std::string("interrupted") : std::string(status.message())) << "; "
            << fitted << " of " << report.frames.size() << " frames are fitted\n";
  return fitted > 0 ? kPartlyDone : kFailed;
}

int Fit(const FitArguments& arguments) {
  if (arguments.cage.empty() && arguments.vertices == 0 && !arguments.options.has_tolerance()) {
    std::cerr
        << "cagefit: expected --template CAGE, or --vertices N or --tolerance T to make one\n";
    return kWrongUsage;
  }
  auto files = ListInputs(arguments.inputs);
  if (!files.ok()) {
    Report(files.status());
    return kWrongUsage;
  }
  Interrupt interrupt;
  FitJob job(arguments, *std::move(files), &interrupt);
  const absl::Status done = job.Run();
  if (!job.has_begun()) {
    const int exit_code = Report(done);
    return absl::IsInvalidArgument(done) ? static_cast<int>(kWrongUsage) : exit_code;
  }
  if (const absl::Status written = job.Finish(); !written.ok()) {
    Report(written);
    return kFailed;
  }
  if (arguments.json) {
    Json json = ReportJson(job.report());
    json.erase("frames");
    std::cout << json.dump() << "\n";
  } else if (Totals(job.report()).fitted > 0) {
    PrintFitTable(job.report(), std::cout);
    std::cout << "Control meshes: " << arguments.out << "/frames and " << arguments.out
              << "/cage.obj; report: " << arguments.out << "/report.json\n";
  }
  if (!done.ok() || interrupt.seen()) {
    return ReportBrokenOff(done, job.report(), interrupt.seen());
  }
  for (const FrameRecord& frame : job.report().frames) {
    if (!frame.status.ok()) {
      std::cerr << "cagefit: " << frame.file << " was refused: " << frame.status.message() << "\n";
    }
  }
  return ExitCodeOf(job.report());
}

}  // namespace

void AddFitCommand(CLI::App* app, Run* run) {
  const auto arguments = std::make_shared<FitArguments>();
  CLI::App* command =
      app->add_subcommand("fit", "Fit a control mesh to a capture, frame after frame");
  AddFitFlags(arguments.get(), command);
  command->callback([arguments, run] { *run = [arguments] { return Fit(*arguments); }; });
}

}  // namespace cagefit::client
