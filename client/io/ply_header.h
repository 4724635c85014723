// The header of a PLY file. Internal to client/io.
#ifndef CAGEFIT_CLIENT_IO_PLY_HEADER_H_
#define CAGEFIT_CLIENT_IO_PLY_HEADER_H_

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace cagefit::client {

enum class ScalarType { kInt8, kUint8, kInt16, kUint16, kInt32, kUint32, kFloat32, kFloat64 };
int ScalarBytes(ScalarType type);
// The number at `bytes`, which hold ScalarBytes(type) bytes.
double ReadScalar(const char* bytes, ScalarType type, bool big_endian);

struct PlyProperty {
  std::string name;
  ScalarType type = ScalarType::kFloat32;  // of the value, or of a list's entries
  bool is_list = false;
  ScalarType count_type = ScalarType::kUint8;
};

struct PlyElement {
  std::string name;
  uint64_t count = 0;
  std::vector<PlyProperty> properties;

  // Its position among the properties, or -1.
  int Find(absl::string_view property) const;
};

enum class PlyEncoding { kAscii, kLittleEndian, kBigEndian };

struct PlyHeader {
  PlyEncoding encoding = PlyEncoding::kAscii;
  std::vector<PlyElement> elements;
  size_t bytes = 0;   // of the header
  int64_t lines = 0;  // of the header
};

// INVALID_ARGUMENT naming the line.
absl::StatusOr<PlyHeader> ReadPlyHeader(absl::string_view bytes);

}  // namespace cagefit::client

#endif  // CAGEFIT_CLIENT_IO_PLY_HEADER_H_
