#include "tests/fuzz/geometry_seeds.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <initializer_list>

#include "absl/strings/str_cat.h"
#include "tests/core/codec/draco_samples.h"

namespace cagefit::testing {
namespace {

template <typename Value>
std::string Raw(std::initializer_list<Value> values, bool big_endian = false) {
  std::string bytes;
  for (const Value value : values) {
    char raw[sizeof(Value)];
    std::memcpy(raw, &value, sizeof(Value));
    if (big_endian) std::reverse(raw, raw + sizeof(Value));
    bytes.append(raw, sizeof(Value));
  }
  return bytes;
}

std::string PlyHeader(const std::string& encoding) {
  return absl::StrCat("ply\nformat ", encoding,
                      " 1.0\ncomment x\nelement vertex 3\nproperty float x\nproperty float y\n"
                      "property float z\nelement face 1\nproperty list uchar int vertex_indices\n"
                      "end_header\n");
}

std::string BinaryPly(bool big) {
  return PlyHeader(big ? "binary_big_endian" : "binary_little_endian") +
         Raw<float>({0, 0, 0, 1, 0, 0, 0, 1, 0}, big) + "\x03" + Raw<int32_t>({0, 1, 2}, big);
}

std::vector<std::string> PlySeeds() {
  return {PlyHeader("ascii") + "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n", BinaryPly(false), BinaryPly(true),
          "ply\nformat ascii 1.0\nelement vertex 2\nproperty double x\nproperty double y\n"
          "property double z\nproperty float nx\nproperty float ny\nproperty float nz\n"
          "property uchar red\nend_header\n1 2 3 0 0 1 255\nnan 1 2 0 1 0 7\n"};
}

std::vector<std::string> ObjSeeds() {
  return {
      "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n"
      "# cagefit crease 1 2\n# cagefit corner 3\n",
      "v 0 0 0\nv 1 0 0 0.5\nv 0 1 0\nv 1 1 0\nvn 0 0 1\nvt 0 1\no thing\nusemtl x\n"
      "f 1/1/1 2//1 \\\n 4//1 3//1\nf -4 -3 -2\n"};
}

std::vector<std::string> StlSeeds() {
  std::string binary(80, ' ');
  binary += Raw<uint32_t>({1}) + Raw<float>({0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0});
  return {
      "solid x\n facet normal 0 0 1\n  outer loop\n   vertex 0 0 0\n   vertex 1 0 0\n"
      "   vertex 0 1 0\n  endloop\n endfacet\nendsolid x\n",
      binary + Raw<uint16_t>({0})};
}

std::string PcdHeader(const std::string& data) {
  return absl::StrCat(
      "# .PCD v0.7\nVERSION 0.7\nFIELDS _ x y z\nSIZE 1 4 4 4\nTYPE U F F F\nCOUNT 2 1 1 1\n"
      "WIDTH 2\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS 2\nDATA ",
      data, "\n");
}

std::vector<std::string> PcdSeeds() {
  const std::string fields = "____" + Raw<float>({1, 4, 2, 5, 3, 6});
  const auto size = static_cast<uint32_t>(fields.size());
  const std::string literal_run(1, static_cast<char>(size - 1));
  return {PcdHeader("ascii") + "0 0 1 2 3\n0 0 nan nan nan\n",
          PcdHeader("binary") + "__" + Raw<float>({1, 2, 3}) + "__" + Raw<float>({4, 5, 6}),
          PcdHeader("binary_compressed") + Raw<uint32_t>({size + 1, size}) + literal_run + fields,
          "FIELDS x y z normal_x normal_y normal_z\nSIZE 4 4 4 4 4 4\nTYPE F F F F F F\nWIDTH 1\n"
          "HEIGHT 1\nDATA ascii\n1 2 3 0 1 0\n"};
}

}  // namespace

std::vector<std::string> GeometrySeeds(const std::string& format) {
  if (format == "ply") return PlySeeds();
  if (format == "obj") return ObjSeeds();
  if (format == "stl") return StlSeeds();
  if (format == "pcd") return PcdSeeds();
  if (format == "off") {
    return {"OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n",
            "COFF # colours\n3 1 0\n0 0 0 255 0 0 255\n1 0 0 0 0 0 1\n0 1 0 1 1 1 1\n3 0 1 2 9\n",
            "CNOFF\n1 0 0\n1 2 3 0 0 1 0.5 0.5 0.5 1\n"};
  }
  if (format == "xyz") {
    return {"x y z nx ny nz\n1 2 3 0 0 1\n4 5 6 0 1 0\n", "2\n1,2,3\n// no\n4;5;6\n# no\n"};
  }
  std::vector<std::string> seeds;
  for (const NamedBytes& sample : AllDracoSamples()) seeds.push_back(sample.bytes);
  return seeds;
}

}  // namespace cagefit::testing
