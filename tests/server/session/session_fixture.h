// Sessions without a network, for tests.
#ifndef CAGEFIT_TESTS_SERVER_SESSION_SESSION_FIXTURE_H_
#define CAGEFIT_TESTS_SERVER_SESSION_SESSION_FIXTURE_H_

#include <gtest/gtest.h>

#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "absl/status/status.h"
#include "absl/time/time.h"
#include "server/session/error_detail.h"
#include "server/session/frame.h"
#include "server/session/session.h"
#include "server/store/memory_journal.h"
#include "tests/support/frames.h"

namespace cagefit::server::testing {

inline double NoTime() { return 0; }

// Reason of the detail, or "" without one.
inline std::string ReasonOf(const absl::Status& status) {
  const auto detail = DetailOf(status);
  return detail.has_value() ? detail->reason : "";
}

// Gives what the test put in.
class FakeTemplates : public TemplateMaker {
 public:
  absl::Status CheckAvailable() const override { return available; }
  absl::StatusOr<ControlMesh> Make(absl::string_view, const TemplateRequest& request,
                                   const CancelFn&) override {
    ++made;
    asked = request;
    return result;
  }

  absl::Status available;
  absl::StatusOr<ControlMesh> result = absl::UnimplementedError("no template was put in");
  int made = 0;
  TemplateRequest asked;
};

inline SessionConfig CageConfig() {
  SessionConfig config;
  config.name = "a test";
  config.control_mesh = cagefit::testing::FrameCage();
  return config;
}

inline Frame DecodedFrame(uint64_t number, std::string bytes,
                          const DecodeLimits& limits = DecodeLimits()) {
  Frame frame;
  frame.sequence_number = number;
  frame.bytes = std::move(bytes);
  DecodeFrame(limits, {}, NoTime, &frame);
  return frame;
}

// Frame `number` of the moving sequence.
inline Frame MovingFrame(uint64_t number) {
  return DecodedFrame(number, cagefit::testing::FrameBytes(
                                  cagefit::testing::MovingCloud(static_cast<int>(number))));
}

inline Frame BadFrame(uint64_t number) { return DecodedFrame(number, "no Draco"); }

// Numbered `number`, of two spheres far apart: no sphere comes near both.
inline Frame FarFrame(uint64_t number) {
  PointCloud cloud = cagefit::testing::SphereCloud(250, {500, 0, 0});
  const PointCloud other = cagefit::testing::SphereCloud(250, {0, 500, 0});
  cloud.points.conservativeResize(3, 500);
  cloud.normals.conservativeResize(3, 500);
  cloud.points.rightCols(250) = other.points;
  cloud.normals.rightCols(250) = other.normals;
  return DecodedFrame(number, cagefit::testing::FrameBytes(cloud));
}

// A cage of 12 vertices, and frames too dense for it to come near.
inline SessionConfig SmallCageConfig() {
  SessionConfig config;
  config.control_mesh = cagefit::testing::FrameCage(0);
  return config;
}

inline Frame DenseFrame(uint64_t number) {
  return DecodedFrame(number, cagefit::testing::FrameBytes(
                                  cagefit::testing::MovingCloud(static_cast<int>(number), 5000)));
}

// A ledger with a journal of its own, in memory.
inline std::shared_ptr<SessionLedger> NewLedger(SessionConfig config,
                                                const SessionLimits& limits = SessionLimits()) {
  struct Both {
    MemoryJournal journal;
    std::optional<SessionLedger> ledger;
  };
  const auto both = std::make_shared<Both>();
  SessionRecord record;
  record.id = "test-session";
  record.created = absl::UnixEpoch();
  if (config.control_mesh.has_value()) {
    record.head.control_vertices = config.control_mesh->vertex_count();
    record.head.triangles = config.control_mesh->topology().triangle_count();
  }
  record.config = std::move(config);
  EXPECT_TRUE(both->journal.Create(record).ok());
  both->ledger.emplace(record, std::nullopt, limits, &both->journal);
  return {both, &*both->ledger};
}

// A session with an open stream.
struct OpenSession {
  explicit OpenSession(SessionConfig config, const SessionLimits& limits = SessionLimits())
      : ledger(NewLedger(std::move(config), limits)), session(ledger, &templates, NoTime) {
    Reopen();
  }

  void Reopen() {
    epoch = ledger->OpenStream([](const absl::Status&) {}).value()->epoch;
  }
  absl::StatusOr<FrameAnswer> Answer(Frame frame, const CancelFn& cancelled = nullptr) {
    return session.Answer(std::move(frame), epoch, cancelled);
  }
  const StoredFrame& Stored(uint64_t number) const { return *ledger->Find(number).value(); }
  // The control vertices after a fitted frame.
  Points3d Vertices(uint64_t number) const { return ledger->MeshOfFrame(number)->vertices(); }

  FakeTemplates templates;
  std::shared_ptr<SessionLedger> ledger;
  Session session;
  uint64_t epoch = 0;
};

}  // namespace cagefit::server::testing

#endif  // CAGEFIT_TESTS_SERVER_SESSION_SESSION_FIXTURE_H_
