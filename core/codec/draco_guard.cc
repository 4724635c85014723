#include "core/codec/draco_guard.h"

#include <draco/compression/config/decoder_options.h>
#include <draco/compression/mesh/mesh_edgebreaker_decoder.h>
#include <draco/compression/mesh/mesh_sequential_decoder.h>
#include <draco/compression/point_cloud/point_cloud_kd_tree_decoder.h>
#include <draco/compression/point_cloud/point_cloud_sequential_decoder.h>

#include <exception>
#include <new>
#include <string>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "core/base/status.h"
#include "core/codec/draco_claims.h"
#include "core/codec/draco_header.h"

namespace cagefit {
namespace {

// Draco's decoders report failure as false; what was wrong with the claims stays in status().
template <typename Decoder>
class Guarded : public Decoder {
 public:
  Guarded(const DracoHeader& header, const DecodeLimits& limits, int64_t encoded_bytes)
      : header_(header), budget_(limits, encoded_bytes) {}

  const absl::Status& status() const { return status_; }

 protected:
  bool DecodeGeometryData() override {
    return Check(CheckGeometryClaims(header_, *this->buffer(), &budget_)) &&
           Decoder::DecodeGeometryData();
  }

  bool DecodePointAttributes() override {
    // Seams split vertices, so a mesh has its number of points only now.
    const int64_t points = this->point_cloud()->num_points();
    return Check(budget_.CheckPoints(points)) &&
           Check(CheckAttributeClaims(header_, points, *this->buffer(), &budget_)) &&
           Decoder::DecodePointAttributes();
  }

  const DracoHeader& header() const { return header_; }

  // Keeps the first failure: Draco may go on for a while after it.
  bool Check(const absl::Status& status) const {
    status_.Update(status);
    return status_.ok();
  }

 private:
  const DracoHeader header_;
  DracoBudget budget_;
  mutable absl::Status status_;
};

class GuardedEdgebreaker final : public Guarded<draco::MeshEdgebreakerDecoder> {
 public:
  using Guarded::Guarded;

  // The one call that comes back from Draco between the kind of a prediction scheme and its data.
  const draco::MeshAttributeIndicesEncodingData* GetAttributeEncodingData(
      int attribute_id) const override {
    const auto* data = Guarded::GetAttributeEncodingData(attribute_id);
    if (data == nullptr) return nullptr;
    const auto values =
        static_cast<int64_t>(data->encoded_attribute_value_index_to_corner_map.size());
    const int components = point_cloud()->attribute(attribute_id)->num_components();
    return Check(CheckPredictionClaims(header(), values, components, *attribute_data_)) ? data
                                                                                        : nullptr;
  }

 protected:
  bool DecodePointAttributes() override {
    attribute_data_ = buffer();
    return Guarded::DecodePointAttributes();
  }

 private:
  const draco::DecoderBuffer* attribute_data_ = nullptr;
};

template <typename GuardedDecoder, typename Geometry>
absl::Status Decode(const DracoHeader& header, const DecodeLimits& limits, absl::string_view bytes,
                    Geometry* geometry) {
  draco::DecoderBuffer buffer;
  buffer.Init(bytes.data(), bytes.size());
  GuardedDecoder decoder(header, limits, static_cast<int64_t>(bytes.size()));
  try {
    const draco::Status status = decoder.Decode(draco::DecoderOptions(), &buffer, geometry);
    if (!decoder.status().ok()) return decoder.status();
    if (!status.ok()) {
      return absl::InvalidArgumentError(absl::StrCat("Draco: ", status.error_msg()));
    }
  } catch (const std::bad_alloc&) {
    return absl::ResourceExhaustedError("out of memory while decoding Draco");
  } catch (const std::exception& error) {
    return absl::InvalidArgumentError(absl::StrCat("Draco: ", error.what()));
  }
  return absl::OkStatus();
}

// Draco itself does not look.
absl::Status CheckFaceIndices(const draco::Mesh& mesh) {
  const uint32_t points = mesh.num_points();
  for (draco::FaceIndex i(0); i < mesh.num_faces(); ++i) {
    for (const draco::PointIndex& index : mesh.face(i)) {
      if (index.value() >= points) {
        return absl::InvalidArgumentError(
            absl::StrFormat("Draco face %d has vertex %d of %d", i.value(), index.value(), points));
      }
    }
  }
  return absl::OkStatus();
}

absl::StatusOr<GuardedGeometry> DecodeWithoutMetadata(const DracoHeader& header,
                                                      const DecodeLimits& limits,
                                                      absl::string_view bytes) {
  GuardedGeometry geometry;
  if (header.is_mesh()) {
    auto mesh = std::make_unique<draco::Mesh>();
    RETURN_IF_ERROR(
        header.method == DracoMethod::kEdgebreakerMesh
            ? Decode<GuardedEdgebreaker>(header, limits, bytes, mesh.get())
            : Decode<Guarded<draco::MeshSequentialDecoder>>(header, limits, bytes, mesh.get()));
    RETURN_IF_ERROR(CheckFaceIndices(*mesh));
    geometry.mesh = mesh.get();
    geometry.points = std::move(mesh);
  } else {
    geometry.points = std::make_unique<draco::PointCloud>();
    RETURN_IF_ERROR(header.method == DracoMethod::kKdTreeCloud
                        ? Decode<Guarded<draco::PointCloudKdTreeDecoder>>(header, limits, bytes,
                                                                          geometry.points.get())
                        : Decode<Guarded<draco::PointCloudSequentialDecoder>>(
                              header, limits, bytes, geometry.points.get()));
  }
  return geometry;
}

}  // namespace

absl::StatusOr<GuardedGeometry> DecodeGuarded(absl::string_view bytes, const DecodeLimits& limits) {
  ASSIGN_OR_RETURN(const DracoHeader header, ReadDracoHeader(bytes));
  if (!header.has_metadata) return DecodeWithoutMetadata(header, limits, bytes);
  if (!limits.allow_metadata) {
    return absl::InvalidArgumentError(
        "Draco bytes with metadata are not accepted here; send them without");
  }
  ASSIGN_OR_RETURN(const std::string stripped, StripDracoMetadata(bytes));
  return DecodeWithoutMetadata(header, limits, stripped);
}

}  // namespace cagefit
