// One `cagefit fit`: files in, one session, one stream, files out.
#ifndef CAGEFIT_CLIENT_COMMANDS_FIT_JOB_H_
#define CAGEFIT_CLIENT_COMMANDS_FIT_JOB_H_

#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "client/commands/fit_options.h"
#include "client/commands/fit_report.h"
#include "client/commands/fitted_meshes.h"
#include "client/commands/folder_follower.h"
#include "client/commands/frame_reader.h"
#include "client/commands/interrupt.h"
#include "client/commands/progress.h"
#include "client/commands/true_motion.h"
#include "client/embedded_server.h"
#include "client/fit_client.h"
#include "client/resuming_stream.h"

namespace cagefit::client {

// A visit is to one frame: of --from-frame and all behind it, and on a round trip to all but the
// last once more, backwards. Its number is the frame's sequence number in the session, so that a
// session alone tells where to go on; a file that cannot be read is sent without bytes, which the
// server rejects.
class FitJob {
 public:
  // `files` are all frames of the input; with `follower`, which then brings them, none. The
  // pointers must outlive the job.
  FitJob(const FitArguments& arguments, std::vector<std::string> files, FolderFollower* follower,
         std::optional<TrueMotion> truth, Interrupt* interrupt);

  // Opens the session.
  absl::Status Begin();

  // Sends and receives all. The report holds whatever came, even when this fails. CANCELLED when it
  // was interrupted.
  absl::Status Run();

  // Measures, and writes what is not written yet.
  absl::Status Finish();

  // When all is done, unless it is to be kept.
  void DeleteSession();

  const FitReport& report() const { return report_; }
  // The first frame without a result.
  size_t first_missing() const;

 private:
  absl::Status Connect();
  absl::StatusOr<v1::CreateSessionRequest> SessionRequest();
  absl::Status OpenSession(const v1::CreateSessionRequest& request);
  absl::Status Stream();
  RetryOptions Retry() const;
  absl::Status TakeEarlier(uint64_t count);
  void SendAll(uint64_t begin);
  absl::Status ReceiveAll(uint64_t begin);
  void Show(size_t visit, const FrameRecord& record, std::optional<Progress>* progress) const;
  // Takes a reply into its frame's record, and its files.
  absl::StatusOr<FrameRecord*> Take(FittedFrame frame);

  // Visits: how many there are, as far as is known.
  size_t VisitCount() const;
  bool IsWayBack(size_t visit) const;
  size_t FrameOfVisit(size_t visit) const;
  FrameRecord* RecordOfVisit(size_t visit);
  // On the sending thread: the file of that frame; nothing when the input ends before it.
  std::optional<std::string> FindFile(size_t frame);
  OutgoingFrame ReadVisit(size_t visit, const std::string& file);
  void AddRecords();

  absl::Status MeasureDrift();
  absl::Status WritePage(Json report) const;  // report.html, as its flag asks for
  Json Settings() const;

  const FitArguments& arguments_;
  FolderFollower* const follower_;
  std::optional<TrueMotion> truth_;
  Interrupt* const interrupt_;
  FrameReader reader_;
  std::unique_ptr<EmbeddedServer> embedded_;
  std::unique_ptr<FitClient> client_;
  std::unique_ptr<ResumingStream> stream_;
  std::optional<ControlMesh> given_cage_;
  std::string started_from_;  // with --from-frame, the file
  std::optional<FittedMeshes> meshes_;
  bool broken_off_ = false;
  bool is_trying_ = false;             // since the last reply, the stream broke
  std::optional<size_t> last_fitted_;  // frame
  FitReport report_;

  std::mutex mutex_;
  std::vector<std::string> files_;             // of every frame so far
  std::map<size_t, absl::Status> unreadable_;  // by visit
};

}  // namespace cagefit::client

#endif  // CAGEFIT_CLIENT_COMMANDS_FIT_JOB_H_
