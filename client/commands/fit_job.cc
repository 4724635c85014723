#include "client/commands/fit_job.h"

#include <algorithm>
#include <chrono>
#include <iostream>
#include <thread>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "client/camera_to_proto.h"
#include "client/commands/drift_report.h"
#include "client/commands/fit_session.h"
#include "client/commands/message_json.h"
#include "client/io/file_bytes.h"
#include "client/io/geometry_file.h"
#include "client/mesh_from_proto.h"
#include "client/report/html_report.h"
#include "core/base/status.h"

namespace cagefit::client {
namespace {

constexpr size_t kMostNameBytes = 200;  // that a server takes

// The beginning of a text in UTF-8, at most so many bytes, in whole characters.
std::string Beginning(const std::string& text, size_t bytes) {
  const auto is_inside = [&](size_t at) { return (text[at] & 0xC0) == 0x80; };
  while (bytes < text.size() && bytes > 0 && is_inside(bytes)) --bytes;
  return text.substr(0, bytes);
}

double Seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

std::string Describe(const FrameRecord& record) {
  if (record.reply.outcome() == v1::OUTCOME_SKIPPED) return "skipped";
  if (!record.status.ok()) return absl::StrCat("refused: ", record.status.message());
  const v1::FrameReply& r = record.reply;
  return absl::StrFormat("RMS %.4f %%, %d steps, %.0f ms%s", r.distances().rms_percent(),
                         r.iterations(), r.milliseconds().index() + r.milliseconds().solve(),
                         r.verdict() == v1::VERDICT_LOST ? ", LOST" : "");
}

}  // namespace

FitJob::FitJob(const FitArguments& arguments, std::vector<std::string> files,
               FolderFollower* follower, std::optional<TrueMotion> truth, Interrupt* interrupt)
    : arguments_(arguments),
      follower_(follower),
      truth_(std::move(truth)),
      interrupt_(interrupt),
      files_(std::move(files)) {
  report_.first_frame = arguments.from_frame;
  if (truth_.has_value()) report_.drift_kind = DriftKind::kTruth;
  AddRecords();
  if (!arguments.round_trip) return;
  report_.drift_kind = DriftKind::kRoundTrip;
  report_.way_back.assign(report_.frames.rbegin() + 1,
                          report_.frames.rend() - static_cast<int64_t>(report_.first_frame));
}

absl::Status FitJob::Begin() {
  RETURN_IF_ERROR(MakeFolder(arguments_.out + "/frames"));
  ASSIGN_OR_RETURN(reader_, FrameReader::Open(arguments_, files_));
  ASSIGN_OR_RETURN(const v1::CreateSessionRequest request, SessionRequest());
  RETURN_IF_ERROR(Connect());
  return OpenSession(request);
}

absl::Status FitJob::Run() {
  const absl::Status streamed = Stream();
  broken_off_ = !streamed.ok();
  AddRecords();
  // What the session says at the end: its options in force and its counts.
  auto session = client_->GetSession(report_.session.session_id());
  if (session.ok()) report_.session = *std::move(session);
  return streamed;
}

absl::StatusOr<v1::CreateSessionRequest> FitJob::SessionRequest() {
  v1::CreateSessionRequest request;
  const std::string& name = arguments_.name.empty() ? arguments_.inputs.front() : arguments_.name;
  request.set_name(Beginning(Utf8(name), kMostNameBytes));
  *request.mutable_options() = arguments_.options;
  for (const Camera& camera : reader_.cameras()) {
    *request.mutable_options()->add_cameras() = client::ToProto(camera);
  }
  std::string cage = arguments_.cage;
  if (arguments_.session.empty()) {
    started_from_ = EarlierMesh(arguments_.out, arguments_.from_frame);
    if (!started_from_.empty()) {
      // Frames before and behind have one connectivity, so nothing is refined any more.
      cage = started_from_;
      request.mutable_options()->clear_tolerance();
      request.mutable_options()->clear_max_vertices();
    }
  }
  if (cage.empty()) {
    request.mutable_make_template()->set_vertices(arguments_.vertices);
    if (arguments_.crease_angle.has_value()) {
      request.mutable_make_template()->set_crease_angle_degrees(*arguments_.crease_angle);
    }
    return request;
  }
  ASSIGN_OR_RETURN(given_cage_, ReadControlMesh(cage));
  *request.mutable_control_mesh() = ToProto(*given_cage_);
  return request;
}

absl::Status FitJob::Connect() {
  ClientOptions options;
  options.address = arguments_.server;
  options.credentials = arguments_.credentials;
  if (options.address.empty()) {
    ASSIGN_OR_RETURN(embedded_, EmbeddedServer::Start(arguments_.threads, arguments_.store));
    options.address = embedded_->address();
    options.credentials = ClientCredentials();
  }
  ASSIGN_OR_RETURN(client_, FitClient::Connect(options));
  return absl::OkStatus();
}

absl::Status FitJob::OpenSession(const v1::CreateSessionRequest& request) {
  if (arguments_.session.empty()) {
    ASSIGN_OR_RETURN(report_.session, client_->CreateSession(request));
  } else {
    ASSIGN_OR_RETURN(report_.session, client_->GetSession(arguments_.session));
    RETURN_IF_ERROR(CheckSameOptions(request.options(), report_.session.options()));
  }
  const std::string& id = report_.session.session_id();
  if (embedded_ == nullptr) std::cerr << "cagefit: session " << id << "\n";
  const bool is_known =
      given_cage_.has_value() && !request.options().has_tolerance() && arguments_.session.empty();
  meshes_.emplace(client_.get(), id, arguments_.out + "/frames",
                  is_known ? given_cage_ : std::nullopt);
  return absl::OkStatus();
}

absl::Status FitJob::Stream() {
  ResumeOptions options;
  if (arguments_.latest) options.mode = v1::FRAME_MODE_LATEST;
  options.retry = Retry();
  options.on_break = [this](const absl::Status& status) {
    if (std::exchange(is_trying_, true)) return;
    std::cerr << "cagefit: the stream broke (" << status.message() << "); trying again\n";
  };
  stream_ = std::make_unique<ResumingStream>(client_.get(), report_.session.session_id(), options);
  interrupt_->SetAction([this] { follower_ != nullptr ? follower_->Stop() : stream_->Cancel(); });
  const double start = Seconds();
  absl::Status status = stream_->Open();
  const uint64_t answered = stream_->next_sequence_number();
  if (status.ok()) status = TakeEarlier(answered);
  if (status.ok()) {
    // The last answered frame once more: the server says when its bytes are others.
    const uint64_t begin = answered == 0 ? 0 : answered - 1;
    std::thread sender([this, begin] { SendAll(begin); });
    status = ReceiveAll(answered);
    if (follower_ != nullptr && !status.ok()) follower_->Stop();
    if (!status.ok()) stream_->Cancel();  // the sender may wait for room that nobody makes
    sender.join();
  }
  interrupt_->SetAction(nullptr);
  report_.seconds = Seconds() - start;
  if (!absl::IsAlreadyExists(status)) return status;
  return absl::Status(status.code(), absl::StrCat("the files are not those that session ",
                                                  report_.session.session_id(),
                                                  " was fitted to: ", status.message()));
}

absl::Status FitJob::TakeEarlier(uint64_t count) {
  if (count == 0) return absl::OkStatus();
  if (follower_ == nullptr && count > VisitCount()) {
    return absl::InvalidArgumentError(absl::StrCat("session ", report_.session.session_id(),
                                                   " has answered ", count,
                                                   " frames; the input has ", VisitCount()));
  }
  v1::GetRepliesRequest request;
  request.set_session_id(report_.session.session_id());
  request.set_count(count);
  const auto take = [this](FittedFrame frame) -> absl::Status {
    const size_t visit = frame.reply.sequence_number();
    const std::optional<std::string> file = FindFile(FrameOfVisit(visit));
    if (!file.has_value() || interrupt_->seen()) return absl::CancelledError("interrupted");
    if (!frame.status.ok()) ReadVisit(visit, *file);  // for what is wrong with the file itself
    return Take(std::move(frame)).status();
  };
  return client_->GetReplies(request, take, Retry());
}

RetryOptions FitJob::Retry() const {
  RetryOptions retry;
  retry.give_up_after = absl::Seconds(arguments_.give_up);
  return retry;
}

void FitJob::SendAll(uint64_t begin) {
  for (size_t visit = begin; follower_ != nullptr || visit < VisitCount(); ++visit) {
    const std::optional<std::string> file = FindFile(FrameOfVisit(visit));
    if (!file.has_value()) break;
    if (!stream_->Send(ReadVisit(visit, *file)).ok()) return;  // the receiver knows why
  }
  stream_->CloseSending().IgnoreError();
}

std::optional<std::string> FitJob::FindFile(size_t frame) {
  while (follower_ != nullptr && files_.size() <= frame) {
    std::optional<std::string> file = follower_->Next();
    if (!file.has_value()) return std::nullopt;
    std::lock_guard<std::mutex> lock(mutex_);
    files_.push_back(*std::move(file));
  }
  return files_[frame];
}

OutgoingFrame FitJob::ReadVisit(size_t visit, const std::string& file) {
  auto read = reader_.Read(FrameOfVisit(visit), file);
  if (!read.ok()) {
    std::lock_guard<std::mutex> lock(mutex_);
    unreadable_[visit] = absl::InvalidArgumentError(read.status().message());
  }
  OutgoingFrame frame = read.ok() ? *std::move(read) : OutgoingFrame();
  frame.sequence_number = visit;
  return frame;
}

absl::Status FitJob::ReceiveAll(uint64_t begin) {
  std::optional<Progress> progress;
  if (!arguments_.json) progress.emplace(follower_ != nullptr ? 0 : VisitCount());
  size_t answered = 0;
  double first = 0;
  while (true) {
    ASSIGN_OR_RETURN(std::optional<FittedFrame> frame, stream_->Receive());
    if (!frame.has_value()) return absl::OkStatus();
    is_trying_ = false;
    const size_t visit = frame->reply.sequence_number();
    ASSIGN_OR_RETURN(const FrameRecord* record, Take(*std::move(frame)));
    if (visit < begin) continue;
    const double now = Seconds();
    if (answered++ == 0) first = now;
    if (answered > 1) report_.frames_per_second = (answered - 1) / (now - first);
    Show(visit, *record, &progress);
  }
}

void FitJob::Show(size_t visit, const FrameRecord& record,
                  std::optional<Progress>* progress) const {
  if (progress->has_value()) (*progress)->Show(visit + 1, Describe(record));
  if (!arguments_.json) return;
  Json json = FrameJson(record, FrameOfVisit(visit), 0);
  if (IsWayBack(visit)) json["way_back"] = true;
  std::cout << Text(json) << std::endl;
}

absl::StatusOr<FrameRecord*> FitJob::Take(FittedFrame frame) {
  const size_t visit = frame.reply.sequence_number();
  FrameRecord* record = RecordOfVisit(visit);
  {
    // What the client saw is more than what the server says of no bytes.
    std::lock_guard<std::mutex> lock(mutex_);
    const auto unreadable = unreadable_.find(visit);
    if (unreadable != unreadable_.end() && !frame.status.ok()) frame.status = unreadable->second;
  }
  RETURN_IF_ERROR(meshes_->Take(std::move(frame), record));
  if (!record->status.ok() || IsWayBack(visit)) return record;
  last_fitted_ = FrameOfVisit(visit);
  RETURN_IF_ERROR(meshes_->Write(*last_fitted_, *record));
  return record;
}

size_t FitJob::VisitCount() const {
  return report_.frames.size() - report_.first_frame + report_.way_back.size();
}

bool FitJob::IsWayBack(size_t visit) const {
  return arguments_.round_trip && visit >= report_.frames.size() - report_.first_frame;
}

size_t FitJob::FrameOfVisit(size_t visit) const {
  if (!IsWayBack(visit)) return report_.first_frame + visit;
  return report_.first_frame + VisitCount() - 1 - visit;
}

FrameRecord* FitJob::RecordOfVisit(size_t visit) {
  if (follower_ != nullptr) AddRecords();
  if (!IsWayBack(visit)) return &report_.frames.at(FrameOfVisit(visit));
  return &report_.way_back.at(visit - (report_.frames.size() - report_.first_frame));
}

void FitJob::AddRecords() {
  std::lock_guard<std::mutex> lock(mutex_);
  const size_t end = arguments_.to_frame.has_value() ? *arguments_.to_frame + 1 : files_.size();
  while (report_.frames.size() < std::min(end, files_.size())) {
    FrameRecord record;
    record.file = files_[report_.frames.size()];
    report_.frames.push_back(std::move(record));
  }
}

size_t FitJob::first_missing() const {
  size_t frame = report_.first_frame;
  while (frame < report_.frames.size() && !absl::IsUnavailable(report_.frames[frame].status)) {
    ++frame;
  }
  return frame;
}

absl::Status FitJob::Finish() {
  const bool is_fitted = last_fitted_.has_value();
  if (is_fitted && !arguments_.quick && !broken_off_) MeasureFrames(*meshes_->cage(), &report_);
  if (report_.diagonal == 0) report_.diagonal = SampledDiagonal(report_);
  report_.settings = Settings();
  // What was fitted is written even where the true motion cannot be read any more.
  const absl::Status measured = MeasureDrift();
  Json json = ReportJson(report_);
  RETURN_IF_ERROR(WriteFileBytes(arguments_.out + "/report.json", Text(json, 2)));
  if (is_fitted) {
    RETURN_IF_ERROR(WriteControlMesh(
        arguments_.out + "/cage.obj",
        meshes_->cage()->WithVertices(report_.frames[*last_fitted_].control_vertices)));
    RETURN_IF_ERROR(WriteSequence(arguments_.formats, *meshes_->cage(), report_.frames,
                                  arguments_.out, arguments_.out + "/frames"));
  }
  if (arguments_.report) RETURN_IF_ERROR(WritePage(std::move(json)));
  return measured;
}

absl::Status FitJob::WritePage(Json report) const {
  HtmlReport page;
  page.report = std::move(report);
  page.frames_per_second = arguments_.formats.frames_per_second;
  page.up_axis = arguments_.formats.up_axis.front();
  if (last_fitted_.has_value()) page.cage = &*meshes_->cage();
  for (size_t k = 0; k < report_.frames.size(); ++k) {
    const FrameRecord& record = report_.frames[k];
    if (record.control_vertices.cols() == 0) continue;  // not fitted
    const double rms = record.distances ? record.distances->rms : record.reply.distances().rms();
    page.frames.push_back({k, record.file, &record.control_vertices, rms});
  }
  return WriteHtmlReport(arguments_.out + "/report.html", page);
}

absl::Status FitJob::MeasureDrift() {
  if (!last_fitted_.has_value() || broken_off_) return absl::OkStatus();
  if (truth_.has_value()) return MeasureTrueDrift(*meshes_->cage(), &*truth_, &report_);
  MeasureRoundTripDrift(*meshes_->cage(), &report_);
  return absl::OkStatus();
}

void FitJob::DeleteSession() {
  if (arguments_.keep_session) return;
  client_->DeleteSession(report_.session.session_id()).IgnoreError();
}

Json FitJob::Settings() const {
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
          {"from_frame", arguments_.from_frame},
          {"to_frame", arguments_.to_frame.has_value() ? Json(*arguments_.to_frame) : Json()},
          {"started_from", started_from_},
          {"options", ToJson(report_.session.options())}};
}

}  // namespace cagefit::client
