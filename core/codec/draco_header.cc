#include "core/codec/draco_header.h"

#include "absl/strings/str_format.h"
#include "core/base/status.h"
#include "core/codec/draco_codec.h"

namespace cagefit {
namespace {

constexpr absl::string_view kMagic = "DRACO";
constexpr size_t kFlagsHighByte = kDracoHeaderBytes - 1;
constexpr int kMetadataFlag = 0x80;

absl::Status CheckVersion(const DracoHeader& header) {
  const int newest = header.is_mesh() ? 202 : 203;
  if (header.version < 100 || header.version > newest) {
    return absl::InvalidArgumentError(absl::StrFormat("Draco bitstream %d.%d of a %s is not known",
                                                      header.version / 100, header.version % 100,
                                                      header.is_mesh() ? "mesh" : "point cloud"));
  }
  // Nothing writes the older kd-tree layouts any more, so checks of them could not be tested.
  if (header.method == DracoMethod::kKdTreeCloud && header.version != newest) {
    return absl::InvalidArgumentError(
        absl::StrFormat("Draco kd-tree cloud of bitstream %d.%d; only 2.3 is read",
                        header.version / 100, header.version % 100));
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<DracoHeader> ReadDracoHeader(absl::string_view bytes) {
  if (bytes.substr(0, kMagic.size()) != kMagic) {
    return absl::InvalidArgumentError("not Draco: the bytes do not begin with \"DRACO\"");
  }
  if (bytes.size() < kDracoHeaderBytes) {
    return absl::InvalidArgumentError(
        absl::StrFormat("Draco header cut off after %d bytes", bytes.size()));
  }
  const auto byte = [&](size_t i) { return static_cast<int>(static_cast<uint8_t>(bytes[i])); };
  const int geometry = byte(7), method = byte(8);
  if (geometry > 1 || method > 1) {
    return absl::InvalidArgumentError(
        absl::StrFormat("Draco geometry type %d with method %d is not known", geometry, method));
  }
  DracoHeader header;
  if (geometry == 0) {
    header.method = method == 0 ? DracoMethod::kSequentialCloud : DracoMethod::kKdTreeCloud;
  } else {
    header.method = method == 0 ? DracoMethod::kSequentialMesh : DracoMethod::kEdgebreakerMesh;
  }
  header.version = 100 * byte(5) + byte(6);
  // Bitstreams before 1.3 have no metadata, whatever the flag says.
  header.has_metadata = (byte(kFlagsHighByte) & kMetadataFlag) != 0 && header.version >= 103;
  RETURN_IF_ERROR(CheckVersion(header));
  return header;
}

absl::StatusOr<DracoInfo> InspectDraco(absl::string_view bytes) {
  ASSIGN_OR_RETURN(const DracoHeader header, ReadDracoHeader(bytes));
  return DracoInfo{header.is_mesh(), header.has_metadata};
}

absl::StatusOr<std::string> StripDracoMetadata(absl::string_view bytes) {
  ASSIGN_OR_RETURN(const DracoHeader header, ReadDracoHeader(bytes));
  if (!header.has_metadata) return std::string(bytes);
  ASSIGN_OR_RETURN(const size_t end, DracoMetadataEnd(bytes));
  std::string stripped;
  stripped.reserve(kDracoHeaderBytes + bytes.size() - end);
  stripped.append(bytes.data(), kDracoHeaderBytes);
  stripped[kFlagsHighByte] = static_cast<char>(stripped[kFlagsHighByte] & ~kMetadataFlag);
  stripped.append(bytes.data() + end, bytes.size() - end);
  return stripped;
}

}  // namespace cagefit
