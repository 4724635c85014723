#include "client/io/gltf_writer.h"

#include <cmath>
#include <cstring>
#include <limits>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "client/io/file_bytes.h"
#include "core/subdiv/shaded_mesh.h"

namespace cagefit::client {
namespace {

using Json = nlohmann::ordered_json;

// Numbers of the specification.
constexpr uint32_t kMagic = 0x46546C67, kVersion = 2;  // "glTF"
constexpr uint32_t kJsonChunk = 0x4E4F534A, kBinaryChunk = 0x004E4942;
constexpr int kFloat = 5126, kUnsignedInt = 5125;                 // component types
constexpr int kVertices = 34962, kIndices = 34963, kAnyData = 0;  // targets of buffer views
constexpr int64_t kMostBytes = std::numeric_limits<uint32_t>::max();

// The one buffer, with a view and an accessor for each array in it.
class Buffer {
 public:
  explicit Buffer(int64_t bytes) { bytes_.reserve(bytes); }

  // Index of the accessor.
  template <typename Value>
  int Add(const Value* values, int64_t count, const char* type, int component_type, int target) {
    const int64_t parts = std::strcmp(type, "VEC3") == 0 ? 3 : 1;
    const auto length = static_cast<int64_t>(sizeof(Value)) * parts * count;
    Json view = {{"buffer", 0}, {"byteOffset", bytes_.size()}, {"byteLength", length}};
    if (target != kAnyData) view["target"] = target;
    bytes_.append(reinterpret_cast<const char*>(values), length);
    accessors_.push_back({{"bufferView", views_.size()},
                          {"componentType", component_type},
                          {"count", count},
                          {"type", type}});
    views_.push_back(std::move(view));
    return static_cast<int>(accessors_.size()) - 1;
  }

  int AddVectors(const Points3f& vectors) {
    return Add(vectors.data(), vectors.cols(), "VEC3", kFloat, kVertices);
  }

  // With the bounds that the specification wants of these.
  int AddPositions(const Points3f& positions) {
    const int accessor = AddVectors(positions);
    const Eigen::Vector3f low = positions.rowwise().minCoeff(),
                          high = positions.rowwise().maxCoeff();
    accessors_[accessor]["min"] = std::vector<float>(low.data(), low.data() + 3);
    accessors_[accessor]["max"] = std::vector<float>(high.data(), high.data() + 3);
    return accessor;
  }

  int AddNumbers(const std::vector<float>& numbers) {
    return Add(numbers.data(), static_cast<int64_t>(numbers.size()), "SCALAR", kFloat, kAnyData);
  }

  void SetBounds(int accessor, float low, float high) {
    accessors_[accessor]["min"].push_back(low);
    accessors_[accessor]["max"].push_back(high);
  }

  const std::string& bytes() const { return bytes_; }
  const Json& views() const { return views_; }
  const Json& accessors() const { return accessors_; }

 private:
  std::string bytes_;
  Json views_ = Json::array(), accessors_ = Json::array();
};

int64_t BytesOf(const ShadedMesh& mesh, int64_t frames) {
  const auto vertices = static_cast<int64_t>(mesh.limit_vertices().size());
  return 4 * mesh.triangles().size() + 24 * vertices * frames + 4 * frames * frames;
}

// The first frame's shape, and per further frame what is to be added to it.
Json AddPrimitive(const ShadedMesh& mesh, const MeshSequence& sequence, Buffer* buffer) {
  const Triangles& triangles = mesh.triangles();
  Json primitive;
  primitive["indices"] =
      buffer->Add(triangles.data(), triangles.size(), "SCALAR", kUnsignedInt, kIndices);
  Points3d positions, normals;
  Points3f first_positions, first_normals;
  for (const MeshSequence::Frame& frame : sequence.frames) {
    mesh.Evaluate(*frame.vertices, &positions, &normals);
    if (first_positions.cols() == 0) {
      first_positions = positions.cast<float>();
      first_normals = normals.cast<float>();
      primitive["attributes"] = {{"POSITION", buffer->AddPositions(first_positions)},
                                 {"NORMAL", buffer->AddVectors(first_normals)}};
      continue;
    }
    positions -= first_positions.cast<double>();
    normals -= first_normals.cast<double>();
    primitive["targets"].push_back({{"POSITION", buffer->AddPositions(positions.cast<float>())},
                                    {"NORMAL", buffer->AddVectors(normals.cast<float>())}});
  }
  primitive["material"] = 0;
  return primitive;
}

// In frame k, weight k - 1 is 1 and all others are 0.
Json AddAnimation(const MeshSequence& sequence, double frames_per_second, Buffer* buffer) {
  const size_t frames = sequence.frames.size(), targets = frames - 1;
  std::vector<float> times(frames), weights(frames * targets);
  for (size_t k = 0; k < frames; ++k) {
    const int64_t behind_first = sequence.frames[k].number - sequence.frames[0].number;
    times[k] = static_cast<float>(static_cast<double>(behind_first) / frames_per_second);
    if (k > 0) weights[k * targets + k - 1] = 1;
  }
  const int input = buffer->AddNumbers(times), output = buffer->AddNumbers(weights);
  buffer->SetBounds(input, times.front(), times.back());
  Json animation = {{"name", "capture"}};
  animation["samplers"].push_back(
      {{"input", input}, {"output", output}, {"interpolation", "LINEAR"}});
  animation["channels"].push_back({{"sampler", 0}, {"target", {{"node", 0}, {"path", "weights"}}}});
  return animation;
}

Json Node(const SceneSettings& settings) {
  Json node = {{"name", "surface"}, {"mesh", 0}};
  if (settings.up_axis == 'Z') {  // a quarter turn about x
    node["rotation"] = {-std::sqrt(0.5), 0, 0, std::sqrt(0.5)};
  }
  const double scale = settings.metres_per_unit;
  if (scale != 1) node["scale"] = {scale, scale, scale};
  return node;
}

void AppendWord(int64_t word, std::string* bytes) {
  const auto value = static_cast<uint32_t>(word);  // little-endian, as all machines that we run on
  bytes->append(reinterpret_cast<const char*>(&value), sizeof(value));
}

void AppendChunk(uint32_t type, std::string chunk, char padding, std::string* bytes) {
  chunk.resize((chunk.size() + 3) / 4 * 4, padding);
  AppendWord(static_cast<int64_t>(chunk.size()), bytes);
  AppendWord(type, bytes);
  bytes->append(chunk);
}

}  // namespace

absl::Status WriteGltf(const std::string& path, const MeshSequence& sequence, int levels,
                       const SceneSettings& settings) {
  if (sequence.frames.empty()) {
    return absl::InvalidArgumentError(absl::StrCat(path, ": no frame to write"));
  }
  const ShadedMesh mesh(*sequence.cage, levels);
  const auto frames = static_cast<int64_t>(sequence.frames.size());
  const int64_t size = BytesOf(mesh, frames);
  if (size + size / 64 > kMostBytes) {
    return absl::InvalidArgumentError(
        absl::StrCat(path, ": ", frames, " frames at ", levels, " levels have ", size,
                     " bytes, and glTF ends at 4 GiB; expected fewer of either"));
  }
  Buffer buffer(size);
  Json gltf = {{"asset", {{"version", "2.0"}, {"generator", "cagefit"}}}, {"scene", 0}};
  gltf["scenes"].push_back({{"nodes", {0}}});
  gltf["nodes"].push_back(Node(settings));
  Json gltf_mesh = {{"name", "surface"}};
  gltf_mesh["primitives"].push_back(AddPrimitive(mesh, sequence, &buffer));
  if (frames > 1) {
    gltf_mesh["weights"] = std::vector<int>(frames - 1);
    for (int64_t k = 1; k < frames; ++k) {
      gltf_mesh["extras"]["targetNames"].push_back(
          absl::StrCat("frame ", sequence.frames[k].number));
    }
    gltf["animations"].push_back(AddAnimation(sequence, settings.frames_per_second, &buffer));
  }
  gltf["meshes"].push_back(std::move(gltf_mesh));
  gltf["materials"].push_back({{"name", "clay"},
                               {"doubleSided", true},
                               {"pbrMetallicRoughness",
                                {{"baseColorFactor", {0.8, 0.8, 0.8, 1}},
                                 {"metallicFactor", 0},
                                 {"roughnessFactor", 0.6}}}});
  gltf["accessors"] = buffer.accessors();
  gltf["bufferViews"] = buffer.views();
  gltf["buffers"].push_back({{"byteLength", buffer.bytes().size()}});

  std::string chunks;
  chunks.reserve(buffer.bytes().size() + (1 << 20));
  AppendChunk(kJsonChunk, gltf.dump(), ' ', &chunks);
  AppendChunk(kBinaryChunk, buffer.bytes(), '\0', &chunks);
  std::string header;
  AppendWord(kMagic, &header);
  AppendWord(kVersion, &header);
  AppendWord(static_cast<int64_t>(3 * sizeof(uint32_t) + chunks.size()), &header);
  return WriteFileBytes(path, chunks.insert(0, header));
}

}  // namespace cagefit::client
