#include <cstdint>

#include "absl/strings/str_format.h"
#include "core/base/status.h"
#include "core/codec/draco_header.h"

namespace cagefit {
namespace {

constexpr int kMaxDepth = 16;

// Every element takes at least one byte, so the time is bounded by the number of bytes whatever the
// counts say.
class MetadataSkipper {
 public:
  explicit MetadataSkipper(absl::string_view bytes) : bytes_(bytes), at_(kDracoHeaderBytes) {}

  absl::StatusOr<size_t> Skip() {
    uint32_t attributes = 0;
    RETURN_IF_ERROR(ReadCount(&attributes));
    for (uint32_t i = 0; i < attributes; ++i) {
      uint32_t unique_id = 0;
      RETURN_IF_ERROR(ReadCount(&unique_id));
      RETURN_IF_ERROR(SkipTree(0));
    }
    RETURN_IF_ERROR(SkipTree(0));
    return at_;
  }

 private:
  absl::Status CutOff() const {
    return absl::InvalidArgumentError(
        absl::StrFormat("Draco metadata cut off at byte %d of %d", at_, bytes_.size()));
  }

  absl::Status Advance(size_t count) {
    if (count > bytes_.size() - at_) return CutOff();
    at_ += count;
    return absl::OkStatus();
  }

  // Seven bits a byte, least significant first, at most five bytes.
  absl::Status ReadCount(uint32_t* value) {
    uint64_t sum = 0;
    for (int shift = 0; shift < 35; shift += 7) {
      if (at_ >= bytes_.size()) return CutOff();
      const uint8_t byte = static_cast<uint8_t>(bytes_[at_++]);
      sum |= static_cast<uint64_t>(byte & 0x7f) << shift;
      if ((byte & 0x80) == 0) {
        *value = static_cast<uint32_t>(sum);
        return absl::OkStatus();
      }
    }
    return absl::InvalidArgumentError(
        absl::StrFormat("Draco metadata: endless number before byte %d", at_));
  }

  absl::Status SkipName() {
    if (at_ >= bytes_.size()) return CutOff();
    const size_t length = static_cast<uint8_t>(bytes_[at_++]);
    return Advance(length);
  }

  absl::Status SkipTree(int depth) {
    if (depth > kMaxDepth) {
      return absl::InvalidArgumentError(
          absl::StrFormat("Draco metadata nested deeper than %d", kMaxDepth));
    }
    uint32_t entries = 0;
    RETURN_IF_ERROR(ReadCount(&entries));
    for (uint32_t i = 0; i < entries; ++i) {
      uint32_t size = 0;
      RETURN_IF_ERROR(SkipName());
      RETURN_IF_ERROR(ReadCount(&size));
      RETURN_IF_ERROR(Advance(size));
    }
    uint32_t children = 0;
    RETURN_IF_ERROR(ReadCount(&children));
    for (uint32_t i = 0; i < children; ++i) {
      RETURN_IF_ERROR(SkipName());
      RETURN_IF_ERROR(SkipTree(depth + 1));
    }
    return absl::OkStatus();
  }

  absl::string_view bytes_;
  size_t at_;
};

}  // namespace

absl::StatusOr<size_t> DracoMetadataEnd(absl::string_view bytes) {
  return MetadataSkipper(bytes).Skip();
}

}  // namespace cagefit
