#include "client/commands/sequence_formats.h"

#include <algorithm>

#include "absl/strings/str_format.h"
#include "client/io/geometry_file.h"
#include "client/io/gltf_writer.h"
#include "client/io/mesh_sequence.h"
#include "client/io/usd_writer.h"
#include "core/base/status.h"

namespace cagefit::client {
namespace {

constexpr int kMostLevels = 4;

}  // namespace

bool SequenceFormats::Contains(const std::string& name) const {
  return std::find(names.begin(), names.end(), name) != names.end();
}

CLI::Option* AddFormatFlags(SequenceFormats* formats, CLI::App* command) {
  CLI::Option* format =
      command
          ->add_option("--format", formats->names,
                       "Write the fitted sequence beside .obj also as: ply (a file a frame), usd "
                       "(one animated subdivision surface, .usda), gltf (its limit surface with "
                       "morph targets, .glb); lists separated by commas")
          ->delimiter(',')
          ->check(CLI::IsMember({"ply", "usd", "gltf"}));
  command
      ->add_option("--fps", formats->frames_per_second, "Frames a second of usd, gltf and a report")
      ->capture_default_str()
      ->check(CLI::Range(1e-3, 1e6));
  command
      ->add_option("--metres-per-unit", formats->metres_per_unit,
                   "Of usd and gltf; the files keep the capture's units and say this")
      ->capture_default_str()
      ->check(CLI::Range(1e-9, 1e9))
      ->needs(format);
  command->add_option("--up-axis", formats->up_axis, "Of usd, gltf and a report")
      ->capture_default_str()
      ->check(CLI::IsMember({"Y", "Z"}));
  command
      ->add_option("--gltf-levels", formats->levels,
                   "Refinement levels of gltf; each takes 4 times the triangles")
      ->capture_default_str()
      ->check(CLI::Range(0, kMostLevels))
      ->needs(format);
  return format;
}

absl::Status WriteSequence(const SequenceFormats& formats, const ControlMesh& cage,
                           const std::vector<FrameRecord>& frames, const std::string& folder,
                           const std::string& frames_folder) {
  MeshSequence sequence;
  sequence.cage = &cage;
  for (size_t frame = 0; frame < frames.size(); ++frame) {
    const Points3d& vertices = frames[frame].control_vertices;
    if (vertices.cols() == 0) continue;  // not fitted
    sequence.frames.push_back({static_cast<int64_t>(frame), &vertices});
    if (!formats.Contains("ply")) continue;
    RETURN_IF_ERROR(WriteMesh(absl::StrFormat("%s/%04d.ply", frames_folder, frame),
                              {vertices, cage.triangles()}));
  }
  const SceneSettings scene = {formats.frames_per_second, formats.metres_per_unit,
                               formats.up_axis.front()};
  if (formats.Contains("usd")) {
    RETURN_IF_ERROR(WriteUsd(folder + "/sequence.usda", sequence, scene));
  }
  if (!formats.Contains("gltf")) return absl::OkStatus();
  return WriteGltf(folder + "/sequence.glb", sequence, formats.levels, scene);
}

Json ToJson(const SequenceFormats& formats) {
  return {{"formats", formats.names},
          {"frames_per_second", formats.frames_per_second},
          {"metres_per_unit", formats.metres_per_unit},
          {"up_axis", formats.up_axis},
          {"levels", formats.levels}};
}

}  // namespace cagefit::client
