#include "client/io/usd_writer.h"

#include "absl/strings/str_cat.h"
#include "client/io/file_bytes.h"
#include "client/io/number_text.h"

namespace cagefit::client {
namespace {

constexpr char kInfinitelySharp[] = "10";  // as USD has it

void Append(const Eigen::Vector3d& point, std::string* text) {
  for (int k = 0; k < 3; ++k) {
    text->append(k == 0 ? "(" : ", ");
    AppendNumber(static_cast<float>(point[k]), text);
  }
  text->push_back(')');
}

// `count` times what `append(k)` writes.
template <typename AppendItem>
void AppendList(int64_t count, std::string* text, const AppendItem& append) {
  text->push_back('[');
  for (int64_t k = 0; k < count; ++k) {
    if (k > 0) text->append(", ");
    append(k);
  }
  text->push_back(']');
}

// One attribute of the mesh: what is in `values`.
template <typename Values>
void AppendInts(const char* name, const Values& values, std::string* text) {
  absl::StrAppend(text, "        int[] ", name, " = ");
  AppendList(static_cast<int64_t>(values.size()), text,
             [&](int64_t k) { absl::StrAppend(text, values[k]); });
  text->push_back('\n');
}

// Likewise, the same `count` times.
void AppendRepeated(const char* type, const char* name, int64_t count, const char* value,
                    std::string* text) {
  absl::StrAppend(text, "        ", type, "[] ", name, " = ");
  AppendList(count, text, [&](int64_t) { text->append(value); });
  text->push_back('\n');
}

void AppendTopology(const ControlMesh& cage, std::string* text) {
  const Triangles& triangles = cage.triangles();
  AppendRepeated("int", "faceVertexCounts", triangles.cols(), "3", text);
  AppendInts("faceVertexIndices",
             std::vector<int32_t>(triangles.data(), triangles.data() + triangles.size()), text);
  const CreaseTags& tags = cage.tags();
  const auto creases = static_cast<int64_t>(tags.edges.size());
  if (creases > 0) {
    std::vector<int32_t> ends;
    for (const auto& [a, b] : tags.edges) ends.insert(ends.end(), {a, b});
    AppendInts("creaseIndices", ends, text);
    AppendRepeated("int", "creaseLengths", creases, "2", text);
    AppendRepeated("float", "creaseSharpnesses", creases, kInfinitelySharp, text);
  }
  if (tags.corners.empty()) return;
  AppendInts("cornerIndices", tags.corners, text);
  AppendRepeated("float", "cornerSharpnesses", static_cast<int64_t>(tags.corners.size()),
                 kInfinitelySharp, text);
}

void AppendMotion(const MeshSequence& sequence, std::string* text) {
  text->append("        float3[] extent.timeSamples = {\n");
  for (const MeshSequence::Frame& frame : sequence.frames) {
    absl::StrAppend(text, "            ", frame.number, ": [");
    Append(frame.vertices->rowwise().minCoeff(), text);
    text->append(", ");
    Append(frame.vertices->rowwise().maxCoeff(), text);
    text->append("],\n");
  }
  text->append("        }\n        point3f[] points.timeSamples = {\n");
  for (const MeshSequence::Frame& frame : sequence.frames) {
    absl::StrAppend(text, "            ", frame.number, ": ");
    AppendList(frame.vertices->cols(), text,
               [&](int64_t v) { Append(frame.vertices->col(v), text); });
    text->append(",\n");
  }
  text->append("        }\n");
}

}  // namespace

absl::Status WriteUsd(const std::string& path, const MeshSequence& sequence,
                      const SceneSettings& settings) {
  if (sequence.frames.empty()) {
    return absl::InvalidArgumentError(absl::StrCat(path, ": no frame to write"));
  }
  std::string text = absl::StrCat(
      "#usda 1.0\n(\n    defaultPrim = \"cagefit\"\n    endTimeCode = ",
      sequence.frames.back().number, "\n    framesPerSecond = ", settings.frames_per_second,
      "\n    metersPerUnit = ", settings.metres_per_unit,
      "\n    startTimeCode = ", sequence.frames.front().number,
      "\n    timeCodesPerSecond = ", settings.frames_per_second, "\n    upAxis = \"",
      std::string(1, settings.up_axis),
      "\"\n)\n\ndef Xform \"cagefit\" (\n    kind = \"component\"\n)\n{\n    def Mesh \"surface\"\n"
      "    {\n        uniform token subdivisionScheme = \"loop\"\n"
      "        token interpolateBoundary = \"edgeOnly\"\n"
      "        uniform token orientation = \"rightHanded\"\n");
  AppendTopology(*sequence.cage, &text);
  AppendMotion(sequence, &text);
  text.append("    }\n}\n");
  return WriteFileBytes(path, text);
}

}  // namespace cagefit::client
