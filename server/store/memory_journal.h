// Sessions for as long as the process lives.
#ifndef CAGEFIT_SERVER_STORE_MEMORY_JOURNAL_H_
#define CAGEFIT_SERVER_STORE_MEMORY_JOURNAL_H_

#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "server/session/journal.h"

namespace cagefit::server {

class MemoryJournal final : public Journal {
 public:
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
  absl::Status Probe() override { return absl::OkStatus(); }
  bool is_durable() const override { return false; }

 private:
  struct Entry {
    SessionRecord record;
    std::optional<ControlMesh> template_mesh;
    std::vector<std::shared_ptr<const StoredFrame>> frames;  // by sequence number
    int begun = 0;                                           // fits of the next frame
    absl::Time last_used;
  };

  // Under the mutex.
  absl::StatusOr<Entry*> Find(const std::string& id);
  absl::StatusOr<Entry*> FindForStream(const std::string& id, uint64_t epoch);

  std::mutex mutex_;
  std::map<std::string, Entry> entries_;
};

}  // namespace cagefit::server

#endif  // CAGEFIT_SERVER_STORE_MEMORY_JOURNAL_H_
