#include "core/codec/draco_guard.h"

#include <draco/compression/mesh/mesh_edgebreaker_decoder.h>
#include <draco/compression/mesh/mesh_sequential_decoder.h>
#include <draco/compression/point_cloud/point_cloud_kd_tree_decoder.h>
#include <draco/compression/point_cloud/point_cloud_sequential_decoder.h>
#include <draco/core/varint_decoding.h>

#include <new>
#include <utility>

#include "absl/strings/str_format.h"
#include "core/base/status.h"

namespace cagefit {

namespace {

// A few bytes can claim any number of points, and be believed: a run of equal symbols costs
// nothing. Real captures take a bit and more a point.
constexpr int64_t kMaxElementsPerByte = 256;

absl::Status CheckCount(const char* what, int64_t value, int64_t limit) {
  if (value > limit) {
    return absl::ResourceExhaustedError(
        absl::StrFormat("draco: %d %s; the limit is %d", value, what, limit));
  }
  if (value <= 0) return absl::InvalidArgumentError(absl::StrFormat("draco: %d %s", value, what));
  return absl::OkStatus();
}

// Reads ahead on a copy of the decoder's buffer and says whether what comes next is acceptable.
class Guard {
 public:
  Guard(const DecodeLimits& limits, int64_t encoded_bytes)
      : limits_(limits), encoded_bytes_(encoded_bytes) {}

  const absl::Status& status() const { return status_; }

  bool Points(int64_t points) {
    return Keep(CheckCount("points", points, limits_.max_points)) &&
           Keep(CheckPlausible("points", points));
  }
  bool Faces(int64_t faces) {
    faces_ = faces;
    return Keep(CheckCount("faces", faces, limits_.max_faces)) &&
           Keep(CheckPlausible("faces", faces));
  }

  // `prefix` bytes per attribute decoder and `suffix` bytes per attribute surround the
  // descriptions.
  bool Attributes(draco::DecoderBuffer ahead, uint16_t version, int64_t points, int prefix,
                  int suffix) {
    return Keep(CheckAttributes(&ahead, version, points, prefix, suffix));
  }

 private:
  bool Keep(absl::Status status) {
    status_.Update(status);
    return status_.ok();
  }

  absl::Status CheckPlausible(const char* what, int64_t value) const {
    if (value <= kMaxElementsPerByte * encoded_bytes_) return absl::OkStatus();
    return absl::InvalidArgumentError(
        absl::StrFormat("draco: %d %s in %d bytes are not plausible", value, what, encoded_bytes_));
  }

  absl::Status CheckAttributes(draco::DecoderBuffer* ahead, uint16_t version, int64_t points,
                               int prefix, int suffix) const {
    const absl::Status truncated =
        absl::InvalidArgumentError("draco: the description of the attributes is cut short");
    uint8_t decoders = 0;
    if (!ahead->Decode(&decoders)) return truncated;
    RETURN_IF_ERROR(CheckCount("attribute groups", decoders, kMaxDracoAttributes));
    ahead->Advance(int64_t{prefix} * decoders);
    int64_t total = 0, bytes_per_point = 0;
    for (int d = 0; d < decoders; ++d) {
      uint32_t attributes = 0;
      const bool read = version < DRACO_BITSTREAM_VERSION(2, 0)
                            ? ahead->Decode(&attributes)
                            : draco::DecodeVarint(&attributes, ahead);
      if (!read) return truncated;
      total += attributes;
      RETURN_IF_ERROR(CheckCount("attributes", total, kMaxDracoAttributes));
      for (uint32_t a = 0; a < attributes; ++a) {
        uint8_t kind = 0, type = 0, components = 0, normalized = 0;
        if (!ahead->Decode(&kind) || !ahead->Decode(&type) || !ahead->Decode(&components) ||
            !ahead->Decode(&normalized)) {
          return truncated;
        }
        RETURN_IF_ERROR(CheckCount("components in an attribute", components, kMaxDracoComponents));
        const int bytes = draco::DataTypeLength(static_cast<draco::DataType>(type));
        if (bytes <= 0) {
          return absl::InvalidArgumentError(
              absl::StrFormat("draco: attribute of unknown type %d", type));
        }
        bytes_per_point += bytes * components;
        uint16_t short_id = 0;
        uint32_t id = 0;
        if (version < DRACO_BITSTREAM_VERSION(1, 3) ? !ahead->Decode(&short_id)
                                                    : !draco::DecodeVarint(&id, ahead)) {
          return truncated;
        }
      }
      ahead->Advance(int64_t{suffix} * attributes);
    }
    return CheckCount("decoded bytes", points * bytes_per_point + 12 * faces_,
                      limits_.max_decoded_bytes);
  }

  const DecodeLimits& limits_;
  int64_t encoded_bytes_;
  int64_t faces_ = 0;
  absl::Status status_;
};

// The four decoders of Draco, each with the guard in front of the two places where counts become
// memory. A point cloud starts with its int32 number of points. kSuffix: sequential coding names a
// decoder per attribute.
template <typename Base, int kSuffix>
class GuardedCloudDecoder : public Base {
 public:
  explicit GuardedCloudDecoder(Guard* guard) : guard_(guard) {}

 protected:
  bool DecodeGeometryData() override {
    draco::DecoderBuffer ahead = *this->buffer();
    int32_t points = 0;
    return ahead.Decode(&points) && guard_->Points(points) && Base::DecodeGeometryData();
  }
  bool DecodePointAttributes() override {
    return guard_->Attributes(*this->buffer(), this->bitstream_version(),
                              this->point_cloud()->num_points(), 0, kSuffix) &&
           Base::DecodePointAttributes();
  }

 private:
  Guard* guard_;
};

bool DecodeCount(draco::DecoderBuffer* ahead, uint16_t version, uint32_t* count) {
  return version < DRACO_BITSTREAM_VERSION(2, 2) ? ahead->Decode(count)
                                                 : draco::DecodeVarint(count, ahead);
}

class GuardedSequentialMeshDecoder : public draco::MeshSequentialDecoder {
 public:
  explicit GuardedSequentialMeshDecoder(Guard* guard) : guard_(guard) {}

 protected:
  bool DecodeConnectivity() override {
    draco::DecoderBuffer ahead = *buffer();
    uint32_t faces = 0, points = 0;
    return DecodeCount(&ahead, bitstream_version(), &faces) &&
           DecodeCount(&ahead, bitstream_version(), &points) && guard_->Faces(faces) &&
           guard_->Points(points) && MeshSequentialDecoder::DecodeConnectivity();
  }
  bool DecodePointAttributes() override {
    return guard_->Attributes(*buffer(), bitstream_version(), point_cloud()->num_points(), 0, 1) &&
           MeshSequentialDecoder::DecodePointAttributes();
  }

 private:
  Guard* guard_;
};

class GuardedEdgebreakerDecoder : public draco::MeshEdgebreakerDecoder {
 public:
  explicit GuardedEdgebreakerDecoder(Guard* guard) : guard_(guard) {}

 protected:
  bool DecodeConnectivity() override {
    // Before 2.2 a count of split vertices comes first.
    draco::DecoderBuffer ahead = *buffer();
    uint32_t new_vertices = 0, vertices = 0, faces = 0;
    if (bitstream_version() < DRACO_BITSTREAM_VERSION(2, 2) &&
        (!ahead.Decode(&new_vertices) || new_vertices > 3u * static_cast<uint32_t>(1 << 28))) {
      return false;
    }
    return DecodeCount(&ahead, bitstream_version(), &vertices) &&
           DecodeCount(&ahead, bitstream_version(), &faces) && guard_->Faces(faces) &&
           guard_->Points(int64_t{vertices} + new_vertices) &&
           MeshEdgebreakerDecoder::DecodeConnectivity();
  }
  bool DecodePointAttributes() override {
    const int prefix = bitstream_version() >= DRACO_BITSTREAM_VERSION(1, 2) ? 3 : 2;
    return guard_->Attributes(*buffer(), bitstream_version(), point_cloud()->num_points(), prefix,
                              1) &&
           MeshEdgebreakerDecoder::DecodePointAttributes();
  }

 private:
  Guard* guard_;
};

template <typename Decoder, typename Geometry>
absl::Status Decode(absl::string_view bytes, const DecodeLimits& limits, Geometry* geometry) {
  Guard guard(limits, static_cast<int64_t>(bytes.size()));
  Decoder decoder(&guard);
  draco::DecoderBuffer buffer;
  buffer.Init(bytes.data(), bytes.size());
  const draco::Status status = decoder.Decode(draco::DecoderOptions(), &buffer, geometry);
  RETURN_IF_ERROR(guard.status());
  if (!status.ok()) {
    return absl::InvalidArgumentError(absl::StrFormat("draco: %s", status.error_msg()));
  }
  return absl::OkStatus();
}

absl::Status CheckFaces(const draco::Mesh& mesh) {
  for (uint32_t f = 0; f < mesh.num_faces(); ++f) {
    for (const draco::PointIndex& index : mesh.face(draco::FaceIndex(f))) {
      if (index.value() >= mesh.num_points()) {
        return absl::InvalidArgumentError(absl::StrFormat("draco: face %d has point index %d of %d",
                                                          f, index.value(), mesh.num_points()));
      }
    }
  }
  return absl::OkStatus();
}

absl::StatusOr<draco::DracoHeader> ReadHeader(absl::string_view bytes) {
  draco::DecoderBuffer buffer;
  buffer.Init(bytes.data(), bytes.size());
  draco::DracoHeader header;
  const draco::Status status = draco::PointCloudDecoder::DecodeHeader(&buffer, &header);
  if (!status.ok() || bytes.size() < 11) {
    return absl::InvalidArgumentError("draco: the bytes do not start with a Draco header");
  }
  const int newest = header.encoder_type == draco::TRIANGULAR_MESH ? 2 * 256 + 2 : 2 * 256 + 3;
  const int version = header.version_major * 256 + header.version_minor;
  if (header.encoder_type > draco::TRIANGULAR_MESH || header.encoder_method > 1 ||
      version > newest || (header.version_major == 0 && header.version_minor < 9)) {
    return absl::InvalidArgumentError(absl::StrFormat(
        "draco: geometry type %d, method %d, bitstream %d.%d is not known", header.encoder_type,
        header.encoder_method, header.version_major, header.version_minor));
  }
  return header;
}

bool HasMetadata(const draco::DracoHeader& header) {
  return (header.flags & METADATA_FLAG_MASK) != 0;
}

}  // namespace

absl::StatusOr<DracoInfo> InspectDraco(absl::string_view bytes) {
  ASSIGN_OR_RETURN(const draco::DracoHeader header, ReadHeader(bytes));
  return DracoInfo{header.encoder_type == draco::TRIANGULAR_MESH, HasMetadata(header)};
}

absl::StatusOr<DecodedDraco> GuardedDecode(absl::string_view bytes,
                                           const DecodeLimits& limits) try {
  ASSIGN_OR_RETURN(const draco::DracoHeader header, ReadHeader(bytes));
  if (HasMetadata(header) && !limits.allow_metadata) {
    return absl::InvalidArgumentError("draco: metadata is not accepted here; encode without it");
  }
  DecodedDraco out;
  if (header.encoder_type == draco::TRIANGULAR_MESH) {
    auto mesh = std::make_unique<draco::Mesh>();
    RETURN_IF_ERROR(header.encoder_method == draco::MESH_SEQUENTIAL_ENCODING
                        ? Decode<GuardedSequentialMeshDecoder>(bytes, limits, mesh.get())
                        : Decode<GuardedEdgebreakerDecoder>(bytes, limits, mesh.get()));
    RETURN_IF_ERROR(CheckFaces(*mesh));
    out.mesh = mesh.get();
    out.cloud = std::move(mesh);
    return out;
  }
  out.cloud = std::make_unique<draco::PointCloud>();
  using Sequential = GuardedCloudDecoder<draco::PointCloudSequentialDecoder, 1>;
  using KdTree = GuardedCloudDecoder<draco::PointCloudKdTreeDecoder, 0>;
  RETURN_IF_ERROR(header.encoder_method == draco::POINT_CLOUD_SEQUENTIAL_ENCODING
                      ? Decode<Sequential>(bytes, limits, out.cloud.get())
                      : Decode<KdTree>(bytes, limits, out.cloud.get()));
  return out;
} catch (const std::bad_alloc&) {
  return absl::ResourceExhaustedError("draco: decoding ran out of memory");
} catch (const std::exception& error) {
  return absl::InvalidArgumentError(absl::StrFormat("draco: %s", error.what()));
}

}  // namespace cagefit
