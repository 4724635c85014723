// Sessions in a SQL database: they survive the process, and the machine.
#ifndef CAGEFIT_SERVER_STORE_SQL_JOURNAL_H_
#define CAGEFIT_SERVER_STORE_SQL_JOURNAL_H_

#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "server/session/journal.h"
#include "server/session/metrics.h"
#include "server/session/record_codec.h"
#include "server/store/database.h"

namespace cagefit::server {

// Several processes may use one database: epochs say whose answers count. After an error of the
// database its connection is closed, and opened anew for the next call, at most every
// kRetryInterval.
class SqlJournal final : public Journal {
 public:
  static constexpr absl::Duration kRetryInterval = absl::Milliseconds(200);
  using ConnectFn = std::function<absl::StatusOr<std::unique_ptr<Database>>()>;

  // At most `connections` at a time. `codec`, and `commits`, which may be null and is told how long
  // commits of answers take, must outlive the journal. A database that cannot be used for now is no
  // error here: Probe says so, and whether it can be later. FAILED_PRECONDITION when it is another
  // program's, or a store of a later version.
  static absl::StatusOr<std::unique_ptr<SqlJournal>> Open(ConnectFn connect, int connections,
                                                          const RecordCodec* codec,
                                                          LatencyHistogram* commits = nullptr);

  absl::Status Create(const SessionRecord& record) override;
  absl::StatusOr<SessionRecord> Load(const std::string& id) override;
  absl::StatusOr<std::optional<ControlMesh>> LoadTemplate(const std::string& id) override;
  absl::StatusOr<std::vector<std::string>> Ids(const std::string& owner, const std::string& after,
                                               size_t count) override;
  absl::StatusOr<int64_t> Count() override;
  absl::StatusOr<int64_t> CountOf(const std::string& owner) override;
  absl::Status Delete(const std::string& id) override;
  absl::StatusOr<SessionHead> RaiseEpoch(const std::string& id) override;
  absl::StatusOr<int> Begin(const std::string& id, uint64_t epoch) override;
  absl::Status Abandon(const std::string& id, uint64_t sequence_number) override;
  absl::Status Append(const std::string& id, uint64_t epoch,
                      std::shared_ptr<const StoredFrame> frame,
                      const ControlMesh* made_template) override;
  absl::StatusOr<std::shared_ptr<const StoredFrame>> Read(const std::string& id,
                                                          uint64_t sequence_number) override;
  absl::StatusOr<std::vector<FrameOutline>> Outlines(const std::string& id) override;
  absl::Status Touch(const std::vector<std::string>& ids, absl::Time now) override;
  absl::StatusOr<std::vector<std::string>> UnusedSince(absl::Time time, size_t count) override;
  // Writes a little and, when the database could not be used before, as much as a frame may need.
  absl::Status Probe() override;
  bool is_durable() const override { return true; }

 private:
  SqlJournal(ConnectFn connect, int connections, const RecordCodec* codec,
             LatencyHistogram* commits)
      : connect_(std::move(connect)), connections_(connections), codec_(codec), commits_(commits) {}

  // What `work` says, with a connection of its own. Closes it after an error of the store's.
  template <typename Work>
  auto With(const Work& work) -> decltype(work(static_cast<Database*>(nullptr)));

  absl::StatusOr<std::unique_ptr<Database>> Take();  // waits for one
  absl::StatusOr<std::unique_ptr<Database>> Connect();
  void GiveBack(std::unique_ptr<Database> database, const absl::Status& status);

  const ConnectFn connect_;
  const int connections_;
  const RecordCodec* const codec_;
  LatencyHistogram* const commits_;  // may be null

  std::mutex mutex_;
  std::condition_variable given_back_;
  std::vector<std::unique_ptr<Database>> idle_;
  int taken_ = 0;      // or being opened
  absl::Status away_;  // why, when none could be opened, or used, the last time
  absl::Time last_try_ = absl::InfinitePast();
};

}  // namespace cagefit::server

#endif  // CAGEFIT_SERVER_STORE_SQL_JOURNAL_H_
