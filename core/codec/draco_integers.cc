#include <cstring>

#include "absl/strings/str_format.h"
#include "core/base/status.h"
#include "core/codec/draco_codec.h"
#include "core/codec/draco_convert.h"
#include "core/codec/draco_guard.h"

namespace cagefit {
namespace {

// Draco's entropy coder takes a table of the size of the largest difference, and its prediction
// overflows near 2^31. Larger values go uncompressed.
constexpr int32_t kMaxCompressed = 1 << 20;

}  // namespace

absl::StatusOr<std::string> EncodeDracoIntegers(const GridPoints& values) {
  if (values.cols() == 0) return absl::InvalidArgumentError("values: none to encode");
  draco::PointCloud cloud;
  cloud.set_num_points(static_cast<uint32_t>(values.cols()));
  const int id = AddAttribute(draco::GeometryAttribute::GENERIC, values, &cloud);
  draco::ExpertEncoder encoder(cloud);
  encoder.SetEncodingMethod(draco::POINT_CLOUD_SEQUENTIAL_ENCODING);
  if (values.minCoeff() < -kMaxCompressed || values.maxCoeff() > kMaxCompressed) {
    encoder.SetUseBuiltInAttributeCompression(false);
    encoder.SetAttributePredictionScheme(id, draco::PREDICTION_NONE);
  }
  return EncodeToString(&encoder);
}

absl::StatusOr<GridPoints> DecodeDracoIntegers(absl::string_view bytes, int64_t max_vertices) {
  DecodeLimits limits;
  limits.max_points = max_vertices;
  ASSIGN_OR_RETURN(const GuardedGeometry geometry, DecodeGuarded(bytes, limits));
  const draco::PointAttribute* attribute =
      geometry.points->GetNamedAttribute(draco::GeometryAttribute::GENERIC);
  const int64_t points = geometry.points->num_points();
  if (geometry.mesh != nullptr || attribute == nullptr ||
      attribute->data_type() != draco::DT_INT32 || attribute->num_components() != 3 ||
      !attribute->is_mapping_identity() || static_cast<int64_t>(attribute->size()) != points) {
    return absl::InvalidArgumentError("Draco bytes hold no int32 attribute of 3 components");
  }
  GridPoints values(3, points);
  std::memcpy(values.data(), attribute->buffer()->data(), sizeof(int32_t) * values.size());
  return values;
}

}  // namespace cagefit
