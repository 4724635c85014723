// Any sequence of FitFrames messages: frames are complete or refused, and every byte of the budget
// comes back.
#include <cstring>
#include <optional>

#include "server/session/error_detail.h"
#include "server/transport/frame_assembler.h"
#include "tests/fuzz/fuzz_target.h"

namespace cagefit::testing {
namespace {

constexpr int64_t kMostFrameBytes = 1000, kBudgetBytes = 1500;

// Each message behind two bytes with its length.
void AddMessage(const v1::FitFramesRequest& message, std::string* bytes) {
  const std::string serialized = message.SerializeAsString();
  const auto size = static_cast<uint16_t>(serialized.size());
  bytes->append(reinterpret_cast<const char*>(&size), sizeof(size));
  bytes->append(serialized);
}

std::optional<v1::FitFramesRequest> NextMessage(absl::string_view* bytes) {
  uint16_t size = 0;
  if (bytes->size() < sizeof(size)) return std::nullopt;
  std::memcpy(&size, bytes->data(), sizeof(size));
  bytes->remove_prefix(sizeof(size));
  const absl::string_view message = bytes->substr(0, size);
  bytes->remove_prefix(message.size());
  v1::FitFramesRequest request;
  if (!request.ParseFromArray(message.data(), static_cast<int>(message.size()))) request.Clear();
  return request;
}

// Returns false at the end of the stream.
bool Take(v1::FitFramesRequest request, server::FrameAssembler* assembler) {
  const uint64_t number = request.header().sequence_number();
  const auto added = assembler->Add(&request);
  if (!added.ok()) {
    FUZZ_CHECK(absl::IsInvalidArgument(added.status()) ||
               absl::IsResourceExhausted(added.status()));
    FUZZ_CHECK(server::DetailOf(added.status()).has_value());
    return false;
  }
  if (!added->has_value()) return true;
  FUZZ_CHECK(assembler->CheckBetweenFrames().ok());
  const server::Frame& frame = (*added)->frame;
  FUZZ_CHECK(static_cast<int64_t>(frame.bytes.size()) <= kMostFrameBytes);
  FUZZ_CHECK(!request.has_header() || (frame.bytes.empty() && frame.sequence_number == number));
  return true;
}

v1::FitFramesRequest Header(uint64_t number, uint64_t bytes) {
  v1::FitFramesRequest request;
  request.mutable_header()->set_sequence_number(number);
  request.mutable_header()->set_total_bytes(bytes);
  return request;
}

v1::FitFramesRequest Chunk(size_t bytes) {
  v1::FitFramesRequest request;
  request.mutable_chunk()->set_data(std::string(bytes, 'x'));
  return request;
}

}  // namespace

std::vector<std::string> FuzzSeeds() {
  std::string plain, rich, empty;
  for (const auto& message : {Header(0, 100), Chunk(60), Chunk(40), Header(1, 10), Chunk(10)}) {
    AddMessage(message, &plain);
  }
  v1::FitFramesRequest header = Header(7, 900);
  header.mutable_header()->mutable_timestamp()->set_seconds(1'700'000'000);
  header.mutable_header()->set_point_count(30);
  header.mutable_header()->add_landmarks()->set_vertex(3);
  header.mutable_header()->add_landmarks()->mutable_surface()->set_u(0.5);
  header.mutable_header()->add_masks()->set_camera("left");
  header.mutable_header()->mutable_masks(0)->set_png_bytes(20);
  for (const auto& message : {header, Chunk(500), Chunk(400)}) AddMessage(message, &rich);
  AddMessage(Header(3, 0), &empty);
  v1::FitFramesRequest open;
  open.mutable_open()->set_session_id("id");
  AddMessage(open, &empty);
  return {plain, rich, empty};
}

}  // namespace cagefit::testing

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace cagefit;
  using namespace cagefit::testing;
  server::MemoryAccount budget("bytes in flight of all calls", kBudgetBytes);
  {
    server::FrameAssembler assembler(kMostFrameBytes, &budget);
    absl::string_view bytes(reinterpret_cast<const char*>(data), size);
    while (auto request = NextMessage(&bytes)) {
      const bool goes_on = Take(*std::move(request), &assembler);
      FUZZ_CHECK(budget.taken() >= 0 && budget.taken() <= kBudgetBytes);
      if (!goes_on) break;
    }
  }
  FUZZ_CHECK(budget.taken() == 0);
  return 0;
}
