// Deltas on both sides: what is encoded comes back to the bit, and a client takes any delta without
// harm.
#include "core/codec/vertex_delta.h"

#include <cstring>

#include "client/delta_decoder.h"
#include "core/codec/draco_codec.h"
#include "tests/fuzz/fuzz_target.h"

namespace cagefit::testing {
namespace {

constexpr int64_t kMostVertices = 1000;

// As many int32 triples as there are bytes for.
GridPoints PointsOf(const uint8_t* data, size_t size) {
  GridPoints q(3, size / 12);
  if (q.cols() > 0) std::memcpy(q.data(), data, 12 * q.cols());  // else both may be null
  return q;
}

void CheckRoundTrip(const uint8_t* data, size_t size) {
  const size_t half = size / 24 * 12;
  const GridPoints before = PointsOf(data, half), after = PointsOf(data + half, half);
  GridPoints q;
  FUZZ_CHECK(ApplyDelta(EncodeKey(before), &q).ok());
  FUZZ_CHECK(q == before);
  VertexDelta delta = EncodeDelta(before, after);
  FUZZ_CHECK(ApplyDelta(delta, &q).ok());
  FUZZ_CHECK(q == after);
  delta.checksum ^= 1;
  FUZZ_CHECK(absl::IsDataLoss(ApplyDelta(delta, &q)));
  FUZZ_CHECK(q == after);
  if (before.cols() == 0) return;
  const auto bytes = EncodeDracoIntegers(before);
  FUZZ_CHECK(bytes.ok());
  FUZZ_CHECK(*DecodeDracoIntegers(*bytes, before.cols()) == before);
}

v1::VertexDelta GoodDelta() {
  const GridPoints q = GridPoints::Random(3, 5);
  v1::VertexDelta delta;
  delta.set_key(true);
  delta.set_quantum(1e-3);
  delta.mutable_packed()->Add(q.data(), q.data() + q.size());
  delta.set_crc32c(Checksum(q));
  return delta;
}

// Whatever came before, a good key frame is applied afterwards.
void CheckDecoder(const std::string& bytes) {
  v1::VertexDelta delta;
  if (!delta.ParseFromString(bytes)) return;
  client::DeltaDecoder decoder;
  const v1::VertexDelta good = GoodDelta();
  FUZZ_CHECK(decoder.Apply(good).ok());
  const Points3d before = decoder.vertices();
  const absl::Status applied = decoder.Apply(delta);
  FUZZ_CHECK(applied.ok() || absl::IsDataLoss(applied));
  FUZZ_CHECK(applied.ok() || decoder.vertices() == before);
  FUZZ_CHECK(decoder.Apply(good).ok());
  FUZZ_CHECK(decoder.vertices() == before);
}

void CheckDraco(const std::string& bytes) {
  const auto values = DecodeDracoIntegers(bytes, kMostVertices);
  FUZZ_CHECK(!values.ok() || values->cols() <= kMostVertices);
}

}  // namespace

std::vector<std::string> FuzzSeeds() {
  v1::VertexDelta packed = GoodDelta(), draco = packed, positions;
  draco.clear_packed();
  GridPoints q(3, 5);
  std::copy(packed.packed().begin(), packed.packed().end(), q.data());
  draco.set_draco(*EncodeDracoIntegers(q));
  positions.set_key(true);
  for (int k = 0; k < 15; ++k) positions.add_positions(static_cast<float>(k));
  return {packed.SerializeAsString(), draco.SerializeAsString(), positions.SerializeAsString(),
          draco.draco(), std::string(reinterpret_cast<const char*>(q.data()), 48)};
}

}  // namespace cagefit::testing

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace cagefit::testing;
  const std::string bytes = BytesOf(data, size);
  CheckRoundTrip(data, size);
  CheckDecoder(bytes);
  CheckDraco(bytes);
  return 0;
}
