#include "server/store/sql_journal.h"

#include <type_traits>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "core/base/status.h"
#include "server/session/fail_point.h"
#include "server/store/frame_table.h"
#include "server/store/schema.h"
#include "server/store/session_table.h"

namespace cagefit::server {
namespace {

constexpr int64_t kSmallProbeBytes = 16, kLargeProbeBytes = 1 << 20;

}  // namespace

absl::StatusOr<std::unique_ptr<SqlJournal>> SqlJournal::Open(ConnectFn connect, int connections,
                                                             const RecordCodec* codec,
                                                             LatencyHistogram* commits) {
  std::unique_ptr<SqlJournal> journal(
      new SqlJournal(std::move(connect), connections, codec, commits));
  auto first = journal->Take();
  if (first.ok()) {
    journal->GiveBack(*std::move(first), absl::OkStatus());
  } else if (absl::IsFailedPrecondition(first.status())) {
    return first.status();
  }
  return journal;
}

absl::StatusOr<std::unique_ptr<Database>> SqlJournal::Connect() {
  ASSIGN_OR_RETURN(std::unique_ptr<Database> database, connect_());
  RETURN_IF_ERROR(Migrate(database.get(), SchemaSteps()));
  return database;
}

absl::StatusOr<std::unique_ptr<Database>> SqlJournal::Take() {
  std::unique_lock<std::mutex> lock(mutex_);
  given_back_.wait(lock, [this] { return !idle_.empty() || taken_ < connections_; });
  while (!idle_.empty()) {
    std::unique_ptr<Database> database = std::move(idle_.back());
    idle_.pop_back();
    if (!database->is_lost()) {
      ++taken_;
      return database;
    }
    away_ = StoreUnavailable("it was lost");
  }
  if (!away_.ok() && absl::Now() < last_try_ + kRetryInterval) return away_;
  ++taken_;
  last_try_ = absl::Now();
  lock.unlock();
  auto database = Connect();
  lock.lock();
  away_ = database.status();
  if (!database.ok()) {
    --taken_;
    given_back_.notify_one();
  }
  return database;
}

void SqlJournal::GiveBack(std::unique_ptr<Database> database, const absl::Status& status) {
  std::vector<std::unique_ptr<Database>> closed;  // outside the lock
  std::lock_guard<std::mutex> lock(mutex_);
  --taken_;
  if (absl::IsUnavailable(status)) {
    away_ = status;
    last_try_ = absl::Now();
    closed.swap(idle_);  // what became of one may have become of all
    closed.push_back(std::move(database));
  } else {
    idle_.push_back(std::move(database));
  }
  given_back_.notify_one();
}

template <typename Work>
auto SqlJournal::With(const Work& work) -> decltype(work(static_cast<Database*>(nullptr))) {
  ASSIGN_OR_RETURN(std::unique_ptr<Database> database, Take());
  auto result = work(database.get());
  if constexpr (std::is_same_v<decltype(result), absl::Status>) {
    GiveBack(std::move(database), result);
  } else {
    GiveBack(std::move(database), result.status());
  }
  return result;
}

absl::Status SqlJournal::Create(const SessionRecord& record) {
  const SessionRow row = {record.owner, record.created, codec_->EncodeConfig(record.config),
                          record.head};
  std::optional<std::string> mesh;
  if (record.config.control_mesh.has_value())
    mesh = codec_->EncodeMesh(*record.config.control_mesh);
  return With([&](Database* database) { return InsertSession(database, record.id, row, mesh); });
}

absl::StatusOr<SessionRecord> SqlJournal::Load(const std::string& id) {
  ASSIGN_OR_RETURN(SessionRow row,
                   With([&](Database* database) { return ReadSession(database, id); }));
  SessionRecord record;
  record.id = id;
  record.owner = std::move(row.owner);
  record.created = row.created;
  record.head = row.head;
  ASSIGN_OR_RETURN(record.config, codec_->DecodeConfig(row.config));
  return record;
}

absl::StatusOr<std::optional<ControlMesh>> SqlJournal::LoadTemplate(const std::string& id) {
  ASSIGN_OR_RETURN(const std::optional<std::string> bytes,
                   With([&](Database* database) { return ReadTemplate(database, id); }));
  if (!bytes.has_value()) return std::optional<ControlMesh>();
  ASSIGN_OR_RETURN(ControlMesh mesh, codec_->DecodeMesh(*bytes));
  return std::optional<ControlMesh>(std::move(mesh));
}

absl::StatusOr<std::vector<std::string>> SqlJournal::Ids(const std::string& owner,
                                                         const std::string& after, size_t count) {
  return With([&](Database* database) { return IdsAfter(database, owner, after, count); });
}

absl::StatusOr<int64_t> SqlJournal::Count() {
  return With([](Database* database) { return database->Number("SELECT count(*) FROM session"); });
}

absl::StatusOr<int64_t> SqlJournal::CountOf(const std::string& owner) {
  return With([&](Database* database) { return CountOfOwner(database, owner); });
}

absl::Status SqlJournal::Delete(const std::string& id) {
  return With([&](Database* database) { return DeleteSession(database, id); });
}

absl::StatusOr<SessionHead> SqlJournal::RaiseEpoch(const std::string& id) {
  return With([&](Database* database) { return server::RaiseEpoch(database, id); });
}

absl::StatusOr<int> SqlJournal::Begin(const std::string& id, uint64_t epoch) {
  return With([&](Database* database) { return BeginFrame(database, id, epoch); });
}

absl::Status SqlJournal::Abandon(const std::string& id, uint64_t sequence_number) {
  return With([&](Database* database) { return AbandonFrame(database, id, sequence_number); });
}

absl::Status SqlJournal::Append(const std::string& id, uint64_t epoch,
                                std::shared_ptr<const StoredFrame> frame,
                                const ControlMesh* made_template) {
  const std::string record = codec_->EncodeFrame(*frame);
  const std::string mesh = made_template != nullptr ? codec_->EncodeMesh(*made_template) : "";
  return With([&](Database* database) -> absl::Status {
    ASSIGN_OR_RETURN(Transaction transaction, Transaction::Begin(database));
    ASSIGN_OR_RETURN(const int64_t session,
                     AdvanceSession(database, id, epoch, *frame, made_template, mesh));
    RETURN_IF_ERROR(InsertFrame(database, session, OutlineOf(*frame), record));
    CAGEFIT_FAIL_POINT("store.before_commit", frame->sequence_number);
    const absl::Time start = absl::Now();
    RETURN_IF_ERROR(transaction.Commit());
    if (commits_ != nullptr) commits_->Observe(absl::ToDoubleSeconds(absl::Now() - start));
    CAGEFIT_FAIL_POINT("store.after_commit", frame->sequence_number);
    return absl::OkStatus();
  });
}

absl::StatusOr<std::shared_ptr<const StoredFrame>> SqlJournal::Read(const std::string& id,
                                                                    uint64_t sequence_number) {
  ASSIGN_OR_RETURN(const std::optional<std::string> record, With([&](Database* database) {
                     return ReadFrame(database, id, sequence_number);
                   }));
  if (!record.has_value()) return std::shared_ptr<const StoredFrame>();
  return codec_->DecodeFrame(*record);
}

absl::StatusOr<std::vector<FrameOutline>> SqlJournal::Outlines(const std::string& id) {
  return With([&](Database* database) { return ReadOutlines(database, id); });
}

absl::Status SqlJournal::Touch(const std::vector<std::string>& ids, absl::Time now) {
  if (ids.empty()) return absl::OkStatus();
  return With([&](Database* database) -> absl::Status {
    ASSIGN_OR_RETURN(Transaction transaction, Transaction::Begin(database));
    for (const std::string& id : ids) RETURN_IF_ERROR(TouchSession(database, id, now));
    return transaction.Commit();
  });
}

absl::StatusOr<std::vector<std::string>> SqlJournal::UnusedSince(absl::Time time, size_t count) {
  return With([&](Database* database) { return IdsUsedBefore(database, time, count); });
}

absl::Status SqlJournal::Probe() {
  bool was_away = false;
  {
    std::lock_guard<std::mutex> lock(mutex_);
    was_away = idle_.empty() && taken_ == 0;
  }
  const std::string bytes(was_away ? kLargeProbeBytes : kSmallProbeBytes, '\0');
  return With([&](Database* database) -> absl::Status {
    ASSIGN_OR_RETURN(Query query,
                     Query::Make(database,
                                 "INSERT INTO probe VALUES (0, ?) "
                                 "ON CONFLICT (key) DO UPDATE SET bytes = excluded.bytes"));
    return query.BindBlob(bytes).Run();
  });
}

}  // namespace cagefit::server
