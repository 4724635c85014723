#include "core/codec/draco_claims.h"

#include <draco/compression/config/compression_shared.h>
#include <draco/compression/entropy/symbol_decoding.h>
#include <draco/core/draco_types.h>
#include <draco/core/varint_decoding.h>

#include <algorithm>
#include <vector>

#include "absl/strings/str_format.h"
#include "core/base/status.h"

namespace cagefit {
namespace {

constexpr int kMaxAttributes = 4;
constexpr int kMaxComponents = 4;

// Entropy coding has no hard bound, but a real capture takes bits per point, not points per bit: a
// flat regular grid of triangles, quantised, has 7 faces a byte. This keeps a few hundred bytes
// from costing seconds.
constexpr int64_t kMaxElementsPerByte = 256;

absl::Status CutOff(absl::string_view where) {
  return absl::InvalidArgumentError(absl::StrFormat("Draco bytes end within the %s", where));
}

// Numbers of connectivity: 32 bits in old bitstreams, variable length in new ones.
bool ReadNumber(bool variable, draco::DecoderBuffer* buffer, uint32_t* value) {
  return variable ? draco::DecodeVarint(value, buffer) : buffer->Decode(value);
}

absl::Status CheckCloud(draco::DecoderBuffer* buffer, DracoBudget* budget) {
  int32_t points = 0;
  if (!buffer->Decode(&points)) return CutOff("number of points");
  return budget->CheckPoints(points);
}

absl::Status CheckSequentialMesh(const DracoHeader& header, draco::DecoderBuffer* buffer,
                                 DracoBudget* budget) {
  const bool variable = header.version >= 202;
  uint32_t faces = 0, points = 0;
  if (!ReadNumber(variable, buffer, &faces) || !ReadNumber(variable, buffer, &points)) {
    return CutOff("numbers of faces and points");
  }
  RETURN_IF_ERROR(budget->CheckFaces(faces));
  RETURN_IF_ERROR(budget->CheckPoints(points));
  return budget->Take(int64_t{faces} * 24);  // the faces, and their indices while they are decoded
}

absl::Status CheckEdgebreakerMesh(const DracoHeader& header, draco::DecoderBuffer* buffer,
                                  DracoBudget* budget) {
  const bool variable = header.version >= 200;
  uint32_t new_vertices = 0, vertices = 0, faces = 0, symbols = 0, splits = 0;
  uint8_t attribute_tables = 0;
  if ((header.version < 202 && !ReadNumber(variable, buffer, &new_vertices)) ||
      !ReadNumber(variable, buffer, &vertices) || !ReadNumber(variable, buffer, &faces) ||
      !buffer->Decode(&attribute_tables) || !ReadNumber(variable, buffer, &symbols) ||
      !ReadNumber(variable, buffer, &splits)) {
    return CutOff("numbers of vertices and faces");
  }
  RETURN_IF_ERROR(budget->CheckFaces(faces));
  RETURN_IF_ERROR(budget->CheckPoints(vertices));
  if (attribute_tables > kMaxAttributes) {
    return absl::InvalidArgumentError(absl::StrFormat(
        "Draco mesh with %d attribute tables; at most %d", attribute_tables, kMaxAttributes));
  }
  if (symbols > faces || splits > symbols || new_vertices > faces) {
    return absl::InvalidArgumentError(
        absl::StrFormat("Draco mesh of %d faces with %d symbols, %d splits and %d new vertices",
                        faces, symbols, splits, new_vertices));
  }
  // Corner table (24 bytes a face, 8 a vertex), traversal (4 and 16) and the faces themselves (12);
  // once more a corner table and its maps for every attribute with seams of its own.
  const int64_t all_vertices = int64_t{vertices} + splits;
  return budget->Take(int64_t{faces} * (40 + 16 * attribute_tables) +
                      all_vertices * (24 + 16 * attribute_tables));
}

// Descriptors of one attribute decoder: type, data type, components, normalised, id.
absl::Status CheckAttributes(const DracoHeader& header, int64_t points,
                             draco::DecoderBuffer* buffer, DracoBudget* budget,
                             int64_t* attributes_so_far) {
  uint32_t attributes = 0;
  if (!ReadNumber(header.version >= 200, buffer, &attributes)) return CutOff("attributes");
  *attributes_so_far += attributes;
  if (attributes == 0 || *attributes_so_far > kMaxAttributes) {
    return absl::InvalidArgumentError(absl::StrFormat(
        "Draco geometry with %d attributes; 1 to %d are read", *attributes_so_far, kMaxAttributes));
  }
  for (uint32_t i = 0; i < attributes; ++i) {
    uint8_t type = 0, data_type = 0, components = 0, normalized = 0;
    uint16_t short_id = 0;
    uint32_t id = 0;
    if (!buffer->Decode(&type) || !buffer->Decode(&data_type) || !buffer->Decode(&components) ||
        !buffer->Decode(&normalized) ||
        !(header.version < 103 ? buffer->Decode(&short_id) : draco::DecodeVarint(&id, buffer))) {
      return CutOff("attributes");
    }
    if (data_type <= draco::DT_INVALID || data_type >= draco::DT_TYPES_COUNT) {
      return absl::InvalidArgumentError(
          absl::StrFormat("Draco attribute %d: unknown data type %d", i, data_type));
    }
    if (components == 0 || components > kMaxComponents) {
      return absl::InvalidArgumentError(absl::StrFormat(
          "Draco attribute %d: %d components; 1 to %d are read", i, components, kMaxComponents));
    }
    // The values, their 32-bit form before dequantisation, and the map from points to values.
    const int64_t bytes_per_value =
        draco::DataTypeLength(static_cast<draco::DataType>(data_type)) + 4;
    RETURN_IF_ERROR(budget->Take(points * (bytes_per_value * components + 8)));
  }
  return absl::OkStatus();
}

// Number of its table, type and, since 1.2, traversal of each attribute decoder. Decoders that
// share a table would mix up each other's values.
absl::Status CheckAttributeTables(const DracoHeader& header, int decoders,
                                  draco::DecoderBuffer* buffer) {
  int8_t tables[kMaxAttributes];
  for (int i = 0; i < decoders; ++i) {
    if (!buffer->Decode(&tables[i])) return CutOff("attributes");
    buffer->Advance(header.version >= 102 ? 2 : 1);
    if (std::find(tables, tables + i, tables[i]) != tables + i) {
      return absl::InvalidArgumentError(
          absl::StrFormat("Draco mesh with two decoders for attribute table %d", tables[i]));
    }
  }
  return absl::OkStatus();
}

// Past the values of an attribute, as a decoder of integers reads them.
bool SkipIntegerValues(int64_t values, int components, draco::DecoderBuffer* buffer) {
  uint8_t compressed = 0, bytes = 0;
  if (!buffer->Decode(&compressed)) return false;
  if (compressed > 0) {
    std::vector<uint32_t> ignored(values * components);
    return draco::DecodeSymbols(static_cast<uint32_t>(ignored.size()), components, buffer,
                                ignored.data());
  }
  if (!buffer->Decode(&bytes) || buffer->remaining_size() < bytes * values * components) {
    return false;
  }
  buffer->Advance(bytes * values * components);
  return true;
}

// The kd-tree repeats the number of points, and believes the repetition.
absl::Status CheckKdTree(int64_t points, draco::DecoderBuffer* buffer) {
  uint8_t level = 0;
  uint32_t bits = 0, repeated = 0;
  if (!buffer->Decode(&level) || !buffer->Decode(&bits) || !buffer->Decode(&repeated)) {
    return CutOff("kd-tree");
  }
  if (repeated != points) {
    return absl::InvalidArgumentError(
        absl::StrFormat("Draco header says %d points, its kd-tree %d", points, int64_t{repeated}));
  }
  return absl::OkStatus();
}

}  // namespace

absl::Status DracoBudget::CheckPoints(int64_t points) const {
  if (points <= 0) {
    return absl::InvalidArgumentError(absl::StrFormat("Draco geometry of %d points", points));
  }
  if (points > limits_.max_points) {
    return absl::ResourceExhaustedError(
        absl::StrFormat("max_points is %d, got %d", limits_.max_points, points));
  }
  if (points > kMaxElementsPerByte * encoded_bytes_) {
    return absl::InvalidArgumentError(
        absl::StrFormat("%d Draco bytes cannot hold %d points", encoded_bytes_, points));
  }
  return absl::OkStatus();
}

absl::Status DracoBudget::CheckFaces(int64_t faces) const {
  if (faces > limits_.max_faces) {
    return absl::ResourceExhaustedError(
        absl::StrFormat("max_faces is %d, got %d", limits_.max_faces, faces));
  }
  if (faces > kMaxElementsPerByte * encoded_bytes_) {
    return absl::InvalidArgumentError(
        absl::StrFormat("%d Draco bytes cannot hold %d faces", encoded_bytes_, faces));
  }
  return absl::OkStatus();
}

absl::Status DracoBudget::Take(int64_t bytes) {
  taken_ += bytes;
  if (taken_ <= limits_.max_decoded_bytes) {
    return limits_.reserve ? limits_.reserve(bytes) : absl::OkStatus();
  }
  return absl::ResourceExhaustedError(
      absl::StrFormat("max_decoded_bytes is %d, needs %d", limits_.max_decoded_bytes, taken_));
}

absl::Status CheckGeometryClaims(const DracoHeader& header, draco::DecoderBuffer buffer,
                                 DracoBudget* budget) {
  if (!header.is_mesh()) return CheckCloud(&buffer, budget);
  if (header.method == DracoMethod::kSequentialMesh) {
    return CheckSequentialMesh(header, &buffer, budget);
  }
  return CheckEdgebreakerMesh(header, &buffer, budget);
}

absl::Status CheckAttributeClaims(const DracoHeader& header, int64_t points,
                                  draco::DecoderBuffer buffer, DracoBudget* budget) {
  uint8_t decoders = 0;
  if (!buffer.Decode(&decoders)) return CutOff("attributes");
  const int max_decoders = header.method == DracoMethod::kKdTreeCloud ? 1 : kMaxAttributes;
  if (decoders == 0 || decoders > max_decoders) {
    return absl::InvalidArgumentError(absl::StrFormat(
        "Draco geometry with %d attribute decoders; 1 to %d are read", decoders, max_decoders));
  }
  if (header.method == DracoMethod::kEdgebreakerMesh) {
    RETURN_IF_ERROR(CheckAttributeTables(header, decoders, &buffer));
  }
  int64_t attributes = 0;
  for (int i = 0; i < decoders; ++i) {
    const int64_t before = attributes;
    RETURN_IF_ERROR(CheckAttributes(header, points, &buffer, budget, &attributes));
    // One byte for the coding of each attribute, except in a kd-tree.
    if (header.method != DracoMethod::kKdTreeCloud) buffer.Advance(attributes - before);
  }
  if (header.method == DracoMethod::kKdTreeCloud) return CheckKdTree(points, &buffer);
  return absl::OkStatus();
}

absl::Status CheckPredictionClaims(const DracoHeader& header, int64_t values, int components,
                                   draco::DecoderBuffer buffer) {
  const auto method = static_cast<int8_t>(buffer.data_head()[-2]);
  const bool old_layout = method == draco::MESH_PREDICTION_TEX_COORDS_DEPRECATED;
  if (!old_layout && method != draco::MESH_PREDICTION_TEX_COORDS_PORTABLE) return absl::OkStatus();
  if (components != 2) {
    return absl::InvalidArgumentError(absl::StrFormat(
        "Draco attribute of %d components predicted like texture coordinates", components));
  }
  uint32_t orientations = 0;
  if (!SkipIntegerValues(values, components, &buffer) ||
      !ReadNumber(old_layout && header.version >= 202, &buffer, &orientations)) {
    return CutOff("texture coordinates");
  }
  if (orientations > values) {
    return absl::InvalidArgumentError(absl::StrFormat(
        "Draco texture coordinates: %d orientations for %d values", int64_t{orientations}, values));
  }
  return absl::OkStatus();
}

}  // namespace cagefit
