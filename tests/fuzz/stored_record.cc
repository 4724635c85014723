// What a store gives back: whatever its bytes are, they are a record or DATA_LOSS, and a record
// that was read is written as it was read.
#include <utility>

#include "server/transport/record_convert.h"
#include "tests/fuzz/fuzz_target.h"
#include "tests/support/frames.h"

namespace cagefit::testing {
namespace {

const server::ProtoRecordCodec kCodec;

void CheckFrame(const std::string& bytes) {
  const auto frame = kCodec.DecodeFrame(bytes);
  FUZZ_CHECK(frame.ok() || absl::IsDataLoss(frame.status()));
  if (!frame.ok()) return;
  const std::string written = kCodec.EncodeFrame(**frame);
  const auto again = kCodec.DecodeFrame(written);
  FUZZ_CHECK(again.ok());
  FUZZ_CHECK(kCodec.EncodeFrame(**again) == written);
  // A session that opens reads the delta, too.
  constexpr int64_t kMostVertices = 1000;
  if ((*frame)->outcome == server::Outcome::kFitted) {
    const auto delta = server::Decode((*frame)->delta, kMostVertices);
    GridPoints q;
    if (delta.ok()) ApplyDelta(*delta, &q).IgnoreError();
  }
}

void CheckConfig(const std::string& bytes) {
  const auto config = kCodec.DecodeConfig(bytes);
  FUZZ_CHECK(config.ok() || absl::IsDataLoss(config.status()));
  if (!config.ok()) return;
  const std::string written = kCodec.EncodeConfig(*config);
  const auto again = kCodec.DecodeConfig(written);
  FUZZ_CHECK(again.ok());
  FUZZ_CHECK(kCodec.EncodeConfig(*again) == written);
}

void CheckMesh(const std::string& bytes) {
  const auto mesh = kCodec.DecodeMesh(bytes);
  FUZZ_CHECK(mesh.ok() || absl::IsDataLoss(mesh.status()));
  if (mesh.ok()) FUZZ_CHECK(kCodec.DecodeMesh(kCodec.EncodeMesh(*mesh)).ok());
}

server::StoredFrame Fitted(server::DeltaEncoding encoding) {
  server::StoredFrame frame;
  frame.outcome = server::Outcome::kFitted;
  frame.control_vertices = 5;
  frame.delta =
      *server::Encode(EncodeKey(GridPoints::Constant(3, 5, 7)), {{1, 2, 3}, 1e-3}, encoding);
  frame.first_box = Box{{0, 0, 0}, {1, 1, 1}};
  frame.tolerance = server::ToleranceReport();
  return frame;
}

}  // namespace

// The first byte says what the rest is.
std::vector<std::string> FuzzSeeds() {
  server::StoredFrame rejected, skipped;
  rejected.error = absl::InvalidArgumentError("no Draco");
  skipped.outcome = server::Outcome::kSkipped;
  server::SessionConfig config;
  config.make_template.vertices = 100;
  return {"f" + kCodec.EncodeFrame(Fitted(server::DeltaEncoding::kPacked)),
          "f" + kCodec.EncodeFrame(Fitted(server::DeltaEncoding::kDraco)),
          "f" + kCodec.EncodeFrame(rejected),
          "f" + kCodec.EncodeFrame(skipped),
          "c" + kCodec.EncodeConfig(config),
          "m" + kCodec.EncodeMesh(FrameCage(0))};
}

}  // namespace cagefit::testing

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace cagefit::testing;
  if (size == 0) return 0;
  const std::string bytes = BytesOf(data + 1, size - 1);
  if (data[0] == 'f') CheckFrame(bytes);
  if (data[0] == 'c') CheckConfig(bytes);
  if (data[0] == 'm') CheckMesh(bytes);
  return 0;
}
