#include "server/store/sqlite_journal.h"

#include <filesystem>
#include <system_error>
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

absl::StatusOr<std::unique_ptr<SqliteJournal>> SqliteJournal::Open(const std::string& path,
                                                                   const RecordCodec* codec,
                                                                   LatencyHistogram* commits) {
  std::error_code error;
  const std::filesystem::path folder = std::filesystem::path(path).parent_path();
  if (!folder.empty() && !std::filesystem::is_directory(folder, error)) {
    return absl::FailedPreconditionError(
        absl::StrCat("the folder of the session store is missing: ", folder.string()));
  }
  std::unique_ptr<SqliteJournal> journal(new SqliteJournal(path, codec, commits));
  std::lock_guard<std::mutex> lock(journal->mutex_);
  const absl::Status connected = journal->Connect();
  if (absl::IsFailedPrecondition(connected)) {
    return absl::FailedPreconditionError(absl::StrCat(path, ": ", connected.message()));
  }
  return journal;
}

absl::Status SqliteJournal::Connect() {
  last_try_ = absl::Now();
  auto database = Database::Open(path_);
  away_ = database.ok() ? Migrate(database->get(), SchemaSteps()) : database.status();
  if (away_.ok()) database_ = *std::move(database);
  return away_;
}

absl::StatusOr<Database*> SqliteJournal::Connection() {
  if (database_ != nullptr && database_->is_replaced()) {
    database_ = nullptr;
    away_ = StoreUnavailable("its file was replaced");
  }
  if (database_ == nullptr) {
    if (absl::Now() < last_try_ + kRetryInterval) return away_;
    RETURN_IF_ERROR(Connect());
  }
  return database_.get();
}

template <typename Work>
auto SqliteJournal::With(const Work& work) -> decltype(work(static_cast<Database*>(nullptr))) {
  std::lock_guard<std::mutex> lock(mutex_);
  ASSIGN_OR_RETURN(Database * database, Connection());
  auto result = work(database);
  absl::Status status;
  if constexpr (std::is_same_v<decltype(result), absl::Status>) {
    status = result;
  } else {
    status = result.status();
  }
  if (absl::IsUnavailable(status)) {
    away_ = status;
    last_try_ = absl::Now();
    database_ = nullptr;
  }
  return result;
}

absl::Status SqliteJournal::Create(const SessionRecord& record) {
  const SessionRow row = {record.owner, record.created, codec_->EncodeConfig(record.config),
                          record.head};
  std::optional<std::string> mesh;
  if (record.config.control_mesh.has_value())
    mesh = codec_->EncodeMesh(*record.config.control_mesh);
  return With([&](Database* database) { return InsertSession(database, record.id, row, mesh); });
}

absl::StatusOr<SessionRecord> SqliteJournal::Load(const std::string& id) {
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

absl::StatusOr<std::optional<ControlMesh>> SqliteJournal::LoadTemplate(const std::string& id) {
  ASSIGN_OR_RETURN(const std::optional<std::string> bytes,
                   With([&](Database* database) { return ReadTemplate(database, id); }));
  if (!bytes.has_value()) return std::optional<ControlMesh>();
  ASSIGN_OR_RETURN(ControlMesh mesh, codec_->DecodeMesh(*bytes));
  return std::optional<ControlMesh>(std::move(mesh));
}

absl::StatusOr<std::vector<std::string>> SqliteJournal::Ids(const std::string& owner,
                                                            const std::string& after,
                                                            size_t count) {
  return With([&](Database* database) { return IdsAfter(database, owner, after, count); });
}

absl::StatusOr<int64_t> SqliteJournal::Count() {
  return With([](Database* database) { return database->Number("SELECT count(*) FROM session"); });
}

absl::StatusOr<int64_t> SqliteJournal::CountOf(const std::string& owner) {
  return With([&](Database* database) { return CountOfOwner(database, owner); });
}

absl::Status SqliteJournal::Delete(const std::string& id) {
  return With([&](Database* database) { return DeleteSession(database, id); });
}

absl::StatusOr<SessionHead> SqliteJournal::RaiseEpoch(const std::string& id) {
  return With([&](Database* database) { return server::RaiseEpoch(database, id); });
}

absl::StatusOr<int> SqliteJournal::Begin(const std::string& id, uint64_t epoch) {
  return With([&](Database* database) { return BeginFrame(database, id, epoch); });
}

absl::Status SqliteJournal::Abandon(const std::string& id, uint64_t sequence_number) {
  return With([&](Database* database) { return AbandonFrame(database, id, sequence_number); });
}

absl::Status SqliteJournal::Append(const std::string& id, uint64_t epoch,
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

absl::StatusOr<std::shared_ptr<const StoredFrame>> SqliteJournal::Read(const std::string& id,
                                                                       uint64_t sequence_number) {
  ASSIGN_OR_RETURN(const std::optional<std::string> record, With([&](Database* database) {
                     return ReadFrame(database, id, sequence_number);
                   }));
  if (!record.has_value()) return std::shared_ptr<const StoredFrame>();
  return codec_->DecodeFrame(*record);
}

absl::StatusOr<std::vector<FrameOutline>> SqliteJournal::Outlines(const std::string& id) {
  return With([&](Database* database) { return ReadOutlines(database, id); });
}

absl::Status SqliteJournal::Touch(const std::vector<std::string>& ids, absl::Time now) {
  if (ids.empty()) return absl::OkStatus();
  return With([&](Database* database) -> absl::Status {
    ASSIGN_OR_RETURN(Transaction transaction, Transaction::Begin(database));
    for (const std::string& id : ids) RETURN_IF_ERROR(TouchSession(database, id, now));
    return transaction.Commit();
  });
}

absl::StatusOr<std::vector<std::string>> SqliteJournal::UnusedSince(absl::Time time, size_t count) {
  return With([&](Database* database) { return IdsUsedBefore(database, time, count); });
}

absl::Status SqliteJournal::Probe() {
  bool was_away = false;
  {
    std::lock_guard<std::mutex> lock(mutex_);
    was_away = database_ == nullptr;
  }
  return With([&](Database* database) -> absl::Status {
    ASSIGN_OR_RETURN(Query query,
                     Query::Make(database, "INSERT OR REPLACE INTO probe VALUES (0, zeroblob(?))"));
    return query.Bind(was_away ? kLargeProbeBytes : kSmallProbeBytes).Run();
  });
}

}  // namespace cagefit::server
