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
#include "client/commands/drift_report.h"
#include "client/commands/fit_options.h"
#include "client/commands/fit_report.h"
#include "client/commands/input_files.h"
#include "client/commands/interrupt.h"
#include "client/commands/landmark_file.h"
#include "client/commands/mask_files.h"
#include "client/commands/message_json.h"
#include "client/commands/progress.h"
#include "client/commands/true_motion.h"
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
  FitJob(const FitArguments& arguments, std::vector<std::string> files,
         std::optional<TrueMotion> truth, Interrupt* interrupt)
      : arguments_(arguments), truth_(std::move(truth)), interrupt_(interrupt) {
    for (std::string& file : files) {
      report_.frames.emplace_back();
      report_.frames.back().file = std::move(file);
    }
    if (truth_.has_value()) report_.drift_kind = DriftKind::kTruth;
    if (!arguments.round_trip) return;
    report_.drift_kind = DriftKind::kRoundTrip;
    report_.way_back.assign(report_.frames.rbegin() + 1, report_.frames.rend());
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
    // What was fitted is written even where the true motion cannot be read any more.
    const absl::Status measured = MeasureDrift();
    RETURN_IF_ERROR(WriteFileBytes(arguments_.out + "/report.json", ReportJson(report_).dump(2)));
    if (last_fitted_ == nullptr) return measured;
    RETURN_IF_ERROR(WriteControlMesh(arguments_.out + "/cage.obj",
                                     cage_->WithVertices(last_fitted_->control_vertices)));
    return measured;
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
    if (!arguments_.landmarks.empty()) {
      ASSIGN_OR_RETURN(landmarks_, ReadLandmarks(arguments_.landmarks, Files()));
    }
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
    std::vector<std::string> names;
    for (const Camera& camera : cameras) {
      names.push_back(camera.name);
      *options->add_cameras() = client::ToProto(camera);
    }
    if (arguments_.masks.empty()) return absl::OkStatus();
    ASSIGN_OR_RETURN(masks_, ListMasks(arguments_.masks, names, Files()));
    return absl::OkStatus();
  }

  std::vector<std::string> Files() const {
    std::vector<std::string> files;
    for (const FrameRecord& frame : report_.frames) files.push_back(frame.file);
    return files;
  }

  absl::Status Connect() {
    ClientOptions options;
    options.address = arguments_.server;
    options.credentials = arguments_.credentials;
    if (options.address.empty()) {
      ASSIGN_OR_RETURN(embedded_, EmbeddedServer::Start(arguments_.threads));
      options.address = embedded_->address();
      options.credentials = ClientCredentials();
    }
    ASSIGN_OR_RETURN(client_, FitClient::Connect(options));
    return absl::OkStatus();
  }

  absl::Status Stream() {
    ASSIGN_OR_RETURN(stream_, client_->OpenStream(report_.session.session_id(),
                                                  arguments_.latest ? v1::FRAME_MODE_LATEST
                                                                    : v1::FRAME_MODE_EVERY));
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

  absl::Status MeasureDrift() {
    if (!cage_.has_value() || interrupt_->seen()) return absl::OkStatus();
    if (truth_.has_value()) return MeasureTrueDrift(*cage_, &*truth_, &report_);
    MeasureRoundTripDrift(*cage_, &report_);
    return absl::OkStatus();
  }

  // Visits: to every frame, and on a round trip to all but the last once more, backwards.
  size_t VisitCount() const { return report_.frames.size() + report_.way_back.size(); }
  bool IsWayBack(size_t visit) const { return visit >= report_.frames.size(); }
  FrameRecord& RecordOfVisit(size_t visit) {
    return IsWayBack(visit) ? report_.way_back[visit - report_.frames.size()]
                            : report_.frames[visit];
  }
  size_t FrameOfVisit(size_t visit) const {
    return IsWayBack(visit) ? VisitCount() - 1 - visit : visit;
  }

  // On a thread of its own. A file that cannot be read is a refused frame and takes no number.
  void SendAll() {
    uint64_t number = 0;
    for (size_t k = 0; k < VisitCount() && !interrupt_->seen(); ++k) {
      FrameRecord& record = RecordOfVisit(k);
      auto read = ReadFrame(FrameOfVisit(k));
      if (!read.ok()) {
        record.status = absl::InvalidArgumentError(read.status().message());
        continue;
      }
      OutgoingFrame frame = *std::move(read);
      frame.sequence_number = number++;
      {
        std::lock_guard<std::mutex> lock(mutex_);
        visit_of_number_.push_back(k);
      }
      if (!stream_->Send(frame).ok()) return;  // the stream has ended; the receiver knows why
    }
    stream_->CloseSending().IgnoreError();
  }

  absl::StatusOr<OutgoingFrame> ReadFrame(size_t index) const {
    OutgoingFrame frame;
    ASSIGN_OR_RETURN(frame.draco,
                     EncodeFrame(report_.frames[index].file, arguments_.position_bits));
    if (!landmarks_.empty()) frame.landmarks = landmarks_[index];
    if (masks_.empty()) return frame;
    ASSIGN_OR_RETURN(frame.masks, ReadMasks(masks_[index]));
    return frame;
  }

  absl::Status ReceiveAll() {
    std::optional<Progress> progress;
    if (!arguments_.json) progress.emplace(VisitCount());
    size_t answered = 0;
    double first = 0;
    while (true) {
      ASSIGN_OR_RETURN(std::optional<FittedFrame> frame, stream_->Receive());
      if (!frame.has_value()) return absl::OkStatus();
      const size_t visit = VisitOfNumber(frame->reply.sequence_number());
      FrameRecord& record = RecordOfVisit(visit);
      RETURN_IF_ERROR(Take(*std::move(frame), visit, &record));
      const double now = Seconds();
      if (answered++ == 0) first = now;
      if (answered > 1) report_.frames_per_second = (answered - 1) / (now - first);
      if (progress.has_value()) progress->Show(visit + 1, Describe(record));
      if (!arguments_.json) continue;
      Json json = FrameJson(record, FrameOfVisit(visit), 0);
      if (IsWayBack(visit)) json["way_back"] = true;
      std::cout << json.dump() << std::endl;
    }
  }

  size_t VisitOfNumber(uint64_t number) {
    std::lock_guard<std::mutex> lock(mutex_);
    return visit_of_number_.at(number);
  }

  absl::Status Take(FittedFrame frame, size_t visit, FrameRecord* record) {
    record->status = frame.status;
    record->delta_bytes = static_cast<int64_t>(frame.reply.delta().ByteSizeLong());
    if (frame.status.ok()) {
      if (!cage_.has_value() || frame.reply.has_tolerance()) {  // which refines a given one
        ASSIGN_OR_RETURN(cage_, MadeTemplate(frame));
      }
      record->control_vertices = std::move(frame.control_vertices);
      if (!IsWayBack(visit)) RETURN_IF_ERROR(Write(visit, record));
    }
    record->reply = std::move(frame.reply);
    record->reply.clear_delta();
    record->reply.clear_template_();
    return absl::OkStatus();
  }

  absl::Status Write(size_t frame, const FrameRecord* record) {
    last_fitted_ = record;
    return WriteControlMesh(absl::StrFormat("%s/frames/%04d.obj", arguments_.out, frame),
                            cage_->WithVertices(record->control_vertices));
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
    if (record.reply.outcome() == v1::OUTCOME_SKIPPED) return "skipped";
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
            {"landmarks", arguments_.landmarks},
            {"server", arguments_.server},
            {"position_bits", arguments_.position_bits},
            {"truth", arguments_.truth},
            {"round_trip", arguments_.round_trip},
            {"latest", arguments_.latest},
            {"options", ToJson(report_.session.options())}};
  }

  const FitArguments& arguments_;
  std::optional<TrueMotion> truth_;
  Interrupt* interrupt_;
  std::unique_ptr<EmbeddedServer> embedded_;
  std::unique_ptr<FitClient> client_;
  std::unique_ptr<FrameStream> stream_;
  // Of every frame, where there are any.
  std::vector<std::vector<MaskFile>> masks_;
  std::vector<std::vector<v1::Landmark>> landmarks_;
  std::mutex mutex_;
  std::vector<size_t> visit_of_number_;  // of every sequence number that was sent
  std::optional<ControlMesh> cage_;      // its connectivity is that of every frame
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

// Checked before a long fit begins.
absl::StatusOr<std::optional<TrueMotion>> OpenTruth(const FitArguments& arguments, size_t frames) {
  if (arguments.truth.empty()) return std::optional<TrueMotion>();
  ASSIGN_OR_RETURN(TrueMotion truth, TrueMotion::Open(arguments.truth, frames));
  RETURN_IF_ERROR(truth.Check());
  return std::optional<TrueMotion>(std::move(truth));
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
  if (arguments.round_trip && files->size() < 2) {
    std::cerr << "cagefit: --round-trip needs a sequence; there is only " << files->front() << "\n";
    return kWrongUsage;
  }
  auto truth = OpenTruth(arguments, files->size());
  if (!truth.ok()) {
    Report(truth.status());
    return kWrongUsage;
  }
  Interrupt interrupt;
  FitJob job(arguments, *std::move(files), *std::move(truth), &interrupt);
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
    if (!frame.status.ok() && frame.reply.outcome() != v1::OUTCOME_SKIPPED) {
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
