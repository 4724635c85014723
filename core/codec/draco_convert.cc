#include "core/codec/draco_convert.h"

#include <cstring>
#include <exception>
#include <memory>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "core/base/status.h"

namespace cagefit {
namespace {

template <typename Scalar>
using Vectors = Eigen::Matrix<Scalar, 3, Eigen::Dynamic>;

// Every value that a point maps to must lie in the attribute's buffer.
absl::Status CheckMapping(const draco::PointAttribute& attribute, int64_t points,
                          const char* name) {
  const int64_t values = static_cast<int64_t>(attribute.size());
  const int64_t needed = attribute.byte_offset() + values * attribute.byte_stride();
  bool inside = attribute.buffer() != nullptr &&
                static_cast<int64_t>(attribute.buffer()->data_size()) >= needed;
  if (attribute.is_mapping_identity()) {
    inside = inside && values >= points;
  } else {
    inside = inside && static_cast<int64_t>(attribute.indices_map_size()) >= points;
    for (draco::PointIndex i(0); inside && i < static_cast<uint32_t>(points); ++i) {
      inside = attribute.mapped_index(i).value() < values;
    }
  }
  if (inside) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrFormat("Draco %s: %d values do not cover %d points", name, values, points));
}

// Stored as Stored: copied without Draco's conversion, which goes through a switch per value.
template <typename Stored, typename Scalar>
void CopyTyped(const draco::PointAttribute& attribute, Vectors<Scalar>* out) {
  const uint8_t* data = attribute.buffer()->data() + attribute.byte_offset();
  const int64_t stride = attribute.byte_stride();
  for (Eigen::Index i = 0; i < out->cols(); ++i) {
    Stored value[3];
    const auto index = attribute.mapped_index(draco::PointIndex(static_cast<uint32_t>(i))).value();
    std::memcpy(value, data + index * stride, sizeof(value));
    out->col(i) << static_cast<Scalar>(value[0]), static_cast<Scalar>(value[1]),
        static_cast<Scalar>(value[2]);
  }
}

template <typename Scalar>
absl::StatusOr<Vectors<Scalar>> ReadVectors(const draco::PointCloud& cloud,
                                            const draco::PointAttribute& attribute,
                                            const char* name) {
  if (attribute.num_components() != 3) {
    return absl::InvalidArgumentError(
        absl::StrFormat("Draco %s with %d components instead of 3", name,
                        static_cast<int>(attribute.num_components())));
  }
  // Draco would read any byte as a bool, which only 0 and 1 are.
  if (attribute.data_type() == draco::DT_BOOL) {
    return absl::InvalidArgumentError(absl::StrFormat("Draco %s of type bool", name));
  }
  RETURN_IF_ERROR(CheckMapping(attribute, cloud.num_points(), name));
  Vectors<Scalar> out(3, cloud.num_points());
  if (attribute.data_type() == draco::DT_FLOAT32) {
    CopyTyped<float>(attribute, &out);
  } else if (attribute.data_type() == draco::DT_FLOAT64) {
    CopyTyped<double>(attribute, &out);
  } else {
    for (Eigen::Index i = 0; i < out.cols(); ++i) {
      const auto index = attribute.mapped_index(draco::PointIndex(static_cast<uint32_t>(i)));
      if (!attribute.ConvertValue<Scalar, 3>(index, out.col(i).data())) {
        return absl::InvalidArgumentError(
            absl::StrFormat("Draco %s of point %d is not a number", name, static_cast<int64_t>(i)));
      }
    }
  }
  if (out.allFinite()) return out;
  Eigen::Index i = 0;
  while (out.col(i).allFinite()) ++i;
  return absl::InvalidArgumentError(
      absl::StrFormat("Draco %s of point %d is not finite: (%g, %g, %g)", name,
                      static_cast<int64_t>(i), out(0, i), out(1, i), out(2, i)));
}

template <typename Scalar>
int AddTyped(draco::GeometryAttribute::Type type, draco::DataType data_type,
             const Vectors<Scalar>& values, draco::PointCloud* cloud) {
  auto attribute = std::make_unique<draco::PointAttribute>();
  attribute->Init(type, 3, data_type, false, static_cast<size_t>(values.cols()));
  attribute->SetIdentityMapping();
  attribute->buffer()->Write(0, values.data(), sizeof(Scalar) * values.size());
  return cloud->AddAttribute(std::move(attribute));
}

}  // namespace

absl::StatusOr<Points3f> ReadVectors3f(const draco::PointCloud& cloud,
                                       const draco::PointAttribute& attribute, const char* name) {
  return ReadVectors<float>(cloud, attribute, name);
}

absl::StatusOr<Points3d> ReadVectors3d(const draco::PointCloud& cloud,
                                       const draco::PointAttribute& attribute, const char* name) {
  return ReadVectors<double>(cloud, attribute, name);
}

absl::StatusOr<const draco::PointAttribute*> PositionAttribute(const draco::PointCloud& cloud) {
  const draco::PointAttribute* positions =
      cloud.GetNamedAttribute(draco::GeometryAttribute::POSITION);
  if (positions == nullptr) return absl::InvalidArgumentError("Draco geometry without positions");
  return positions;
}

int AddAttribute(draco::GeometryAttribute::Type type, const Points3f& values,
                 draco::PointCloud* cloud) {
  return AddTyped(type, draco::DT_FLOAT32, values, cloud);
}

int AddAttribute(draco::GeometryAttribute::Type type, const GridPoints& values,
                 draco::PointCloud* cloud) {
  return AddTyped(type, draco::DT_INT32, values, cloud);
}

absl::StatusOr<std::string> EncodeToString(draco::ExpertEncoder* encoder) {
  draco::EncoderBuffer buffer;
  try {
    const draco::Status status = encoder->EncodeToBuffer(&buffer);
    if (!status.ok()) return absl::InternalError(absl::StrCat("Draco: ", status.error_msg()));
  } catch (const std::exception& error) {
    return absl::InternalError(absl::StrCat("Draco: ", error.what()));
  }
  return std::string(buffer.data(), buffer.size());
}

}  // namespace cagefit
