#include "tests/support/mesh_file.h"

#include <cstdint>
#include <cstring>
#include <fstream>
#include <map>
#include <sstream>
#include <stdexcept>
#include <vector>

#include "tests/support/data.h"

namespace cagefit::testing {

namespace {

void Check(bool ok, const std::string& what) {
  if (!ok) throw std::runtime_error(what);
}

TriangleMesh FromLists(const std::vector<double>& coordinates,
                       const std::vector<int32_t>& indices) {
  TriangleMesh mesh;
  mesh.vertices = Eigen::Map<const Points3d>(coordinates.data(), 3,
                                             static_cast<Eigen::Index>(coordinates.size() / 3));
  mesh.triangles =
      Eigen::Map<const Triangles>(indices.data(), 3, static_cast<Eigen::Index>(indices.size() / 3));
  return mesh;
}

TriangleMesh ReadObj(std::istream& in) {
  std::vector<double> coordinates;
  std::vector<int32_t> indices;
  std::string line, word;
  while (std::getline(in, line)) {
    std::istringstream words(line);
    if (!(words >> word)) continue;
    if (word == "v") {
      double x, y, z;
      Check(static_cast<bool>(words >> x >> y >> z), "bad line: " + line);
      coordinates.insert(coordinates.end(), {x, y, z});
    } else if (word == "f") {
      int corners = 0;
      for (; words >> word; ++corners) indices.push_back(std::stoi(word) - 1);
      Check(corners == 3, "not a triangle: " + line);
    }
  }
  return FromLists(coordinates, indices);
}

struct PlyHeader {
  size_t vertices = 0, faces = 0, stride = 0;
  std::map<std::string, std::pair<size_t, bool>> fields;  // name: offset, is double
};

PlyHeader ReadPlyHeader(std::istream& in) {
  const std::map<std::string, size_t> sizes = {{"char", 1},   {"uchar", 1}, {"short", 2},
                                               {"ushort", 2}, {"int", 4},   {"uint", 4},
                                               {"float", 4},  {"double", 8}};
  PlyHeader header;
  std::string line, word, element;
  while (std::getline(in, line) && line != "end_header") {
    std::istringstream words(line);
    words >> word;
    if (word == "format") {
      Check(line == "format binary_little_endian 1.0", line);
    } else if (word == "element") {
      words >> element;
      words >> (element == "vertex" ? header.vertices : header.faces);
    } else if (word == "property" && element == "vertex") {
      std::string type, name;
      words >> type >> name;
      header.fields[name] = {header.stride, type == "double"};
      header.stride += sizes.at(type);
    } else if (word == "property") {
      Check(line.rfind("property list uchar int ", 0) == 0, line);
    }
  }
  return header;
}

TriangleMesh ReadPly(std::istream& in) {
  const PlyHeader header = ReadPlyHeader(in);
  TriangleMesh mesh;
  mesh.vertices.resize(3, static_cast<Eigen::Index>(header.vertices));
  std::vector<char> row(header.stride);
  const char* const names[3] = {"x", "y", "z"};
  for (Eigen::Index v = 0; v < mesh.vertices.cols(); ++v) {
    in.read(row.data(), static_cast<std::streamsize>(row.size()));
    for (int axis = 0; axis < 3; ++axis) {
      const auto [offset, is_double] = header.fields.at(names[axis]);
      float single;
      std::memcpy(&single, row.data() + offset, sizeof(single));
      mesh.vertices(axis, v) = single;
      if (is_double) std::memcpy(&mesh.vertices(axis, v), row.data() + offset, sizeof(double));
    }
  }
  mesh.triangles.resize(3, static_cast<Eigen::Index>(header.faces));
  for (Eigen::Index f = 0; f < mesh.triangles.cols(); ++f) {
    Check(in.get() == 3, "not a triangle");
    in.read(reinterpret_cast<char*>(mesh.triangles.col(f).data()), 3 * sizeof(int32_t));
  }
  Check(in.good(), "too short");
  return mesh;
}

}  // namespace

TriangleMesh ReadTestMesh(const std::string& name) {
  std::ifstream in(DataDir() + "/" + name, std::ios::binary);
  Check(in.good(), name + ": cannot open");
  try {
    const bool obj = name.size() > 4 && name.substr(name.size() - 4) == ".obj";
    return obj ? ReadObj(in) : ReadPly(in);
  } catch (const std::exception& error) {
    throw std::runtime_error(name + ": " + error.what());
  }
}

}  // namespace cagefit::testing
