#include <cmath>
#include <limits>

#include "absl/strings/str_cat.h"
#include "client/mesh_from_proto.h"
#include "tests/server/malformed/malformed_request.h"
#include "tests/support/frames.h"
#include "tests/support/shapes.h"

namespace cagefit::server::testing {
namespace {

using SpoilFn = std::function<void(v1::ControlMesh*)>;

// The icosahedron that `spoil` has made malformed.
MalformedRequest Mesh(const std::string& name, const std::string& message, const SpoilFn& spoil) {
  MalformedRequest request;
  request.name = name;
  request.send = [spoil](const Target& target) {
    v1::CreateSessionRequest create;
    *create.mutable_control_mesh() = client::ToProto(cagefit::testing::FrameCage(0));
    spoil(create.mutable_control_mesh());
    return target.client->CreateSession(create).status();
  };
  request.reason = "INVALID_CONTROL_MESH";
  request.field = "control_mesh";
  request.message = message;
  return request;
}

MalformedRequest Length(const std::string& field, const std::string& value, const SpoilFn& spoil) {
  MalformedRequest request = Mesh(field + " " + value, field + " is " + value, spoil);
  request.reason = "INVALID_FIELD";
  request.field = field;
  request.value = value;
  return request;
}

MalformedRequest Limit(const std::string& field, int64_t value, const SpoilFn& spoil) {
  MalformedRequest request = Mesh(absl::StrCat(value, " ", field), "", spoil);
  request.code = absl::StatusCode::kResourceExhausted;
  request.reason = "LIMIT_EXCEEDED";
  request.field = field;
  request.value = absl::StrCat(value);
  return request;
}

void SetTriangles(std::initializer_list<uint32_t> indices, v1::ControlMesh* mesh) {
  mesh->clear_triangles();
  for (const uint32_t index : indices) mesh->add_triangles(index);
}

void AddTriangle(std::initializer_list<uint32_t> indices, v1::ControlMesh* mesh) {
  for (const uint32_t index : indices) mesh->add_triangles(index);
}

void AddLengths(std::vector<MalformedRequest>* requests) {
  requests->push_back(Length("control_mesh.vertices", "35 values long", [](v1::ControlMesh* mesh) {
    mesh->mutable_vertices()->RemoveLast();
  }));
  requests->push_back(Length("control_mesh.triangles", "59 values long", [](v1::ControlMesh* mesh) {
    mesh->mutable_triangles()->RemoveLast();
  }));
  requests->push_back(
      Length("control_mesh.crease_edges", "3 values long", [](v1::ControlMesh* mesh) {
        for (const uint32_t v : {0, 1, 2}) mesh->add_crease_edges(v);
      }));
  requests->push_back(Limit("control vertices", kMaxControlVertices + 1, [](v1::ControlMesh* mesh) {
    mesh->mutable_vertices()->Resize(3 * (kMaxControlVertices + 1), 0);
  }));
}

void AddNumbers(std::vector<MalformedRequest>* requests) {
  for (const double value : {std::nan(""), std::numeric_limits<double>::infinity(),
                             -std::numeric_limits<double>::infinity()}) {
    requests->push_back(Mesh(absl::StrCat("vertex 2 has ", value), "vertex 2",
                             [value](v1::ControlMesh* mesh) { mesh->set_vertices(7, value); }));
  }
  for (const uint32_t index : {12u, 0x7FFFFFFFu, 0x80000000u, 0xFFFFFFFFu}) {
    requests->push_back(Mesh(absl::StrCat("triangle 0 has vertex ", index), "triangle 0",
                             [index](v1::ControlMesh* mesh) { mesh->set_triangles(1, index); }));
    requests->push_back(Mesh(absl::StrCat("a crease edge has vertex ", index), "crease edge",
                             [index](v1::ControlMesh* mesh) {
                               mesh->add_crease_edges(0);
                               mesh->add_crease_edges(index);
                             }));
    requests->push_back(Mesh(absl::StrCat("corner ", index), "corner",
                             [index](v1::ControlMesh* mesh) { mesh->add_corners(index); }));
  }
  requests->push_back(
      Mesh("a crease edge that is no edge", "crease edge (0, 0)", [](v1::ControlMesh* mesh) {
        mesh->add_crease_edges(0);
        mesh->add_crease_edges(0);
      }));
}

void AddTopologies(std::vector<MalformedRequest>* requests) {
  requests->push_back(Mesh("empty", "", [](v1::ControlMesh* mesh) { mesh->Clear(); }));
  requests->push_back(
      Mesh("no triangles", "", [](v1::ControlMesh* mesh) { mesh->clear_triangles(); }));
  requests->push_back(
      Mesh("no vertices", "", [](v1::ControlMesh* mesh) { mesh->clear_vertices(); }));
  requests->push_back(Mesh("a vertex twice in a triangle", "triangle 0", [](v1::ControlMesh* mesh) {
    mesh->set_triangles(1, mesh->triangles(0));
  }));
  requests->push_back(Mesh("a triangle turned round", "edge", [](v1::ControlMesh* mesh) {
    mesh->mutable_triangles()->SwapElements(0, 1);
  }));
  requests->push_back(Mesh("a triangle twice", "edge", [](v1::ControlMesh* mesh) {
    AddTriangle({mesh->triangles(0), mesh->triangles(1), mesh->triangles(2)}, mesh);
  }));
  requests->push_back(Mesh("three triangles at an edge", "edge", [](v1::ControlMesh* mesh) {
    for (const double x : {3.0, 0.0, 0.0}) mesh->add_vertices(x);
    AddTriangle({mesh->triangles(0), mesh->triangles(1), 12}, mesh);
  }));
  requests->push_back(Mesh("a vertex without triangles", "vertex 12", [](v1::ControlMesh* mesh) {
    for (const double x : {3.0, 0.0, 0.0}) mesh->add_vertices(x);
  }));
  requests->push_back(Mesh("two fans at a vertex", "vertex", [](v1::ControlMesh* mesh) {
    SetTriangles({0, 1, 2, 0, 3, 4}, mesh);
    mesh->mutable_vertices()->Truncate(15);
  }));
  requests->push_back(Mesh("an interior vertex of valence 2", "vertex", [](v1::ControlMesh* mesh) {
    SetTriangles({0, 1, 2, 0, 2, 1}, mesh);
    mesh->mutable_vertices()->Truncate(9);
  }));
  requests->push_back(Mesh("a triangle without area", "area is 0", [](v1::ControlMesh* mesh) {
    const uint32_t from = mesh->triangles(0), to = mesh->triangles(1);
    for (uint32_t k = 0; k < 3; ++k) mesh->set_vertices(3 * to + k, mesh->vertices(3 * from + k));
  }));
}

}  // namespace

std::vector<MalformedRequest> MalformedMeshes() {
  std::vector<MalformedRequest> requests;
  AddLengths(&requests);
  AddNumbers(&requests);
  AddTopologies(&requests);
  return requests;
}

}  // namespace cagefit::server::testing
