// A fitted sequence in the formats of other programs, beside its .obj files.
#ifndef CAGEFIT_CLIENT_COMMANDS_SEQUENCE_FORMATS_H_
#define CAGEFIT_CLIENT_COMMANDS_SEQUENCE_FORMATS_H_

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "client/commands/fit_report.h"
#include "client/commands/json.h"
#include "core/mesh/control_mesh.h"

namespace cagefit::client {

struct SequenceFormats {
  std::vector<std::string> names;  // of "ply", "usd", "gltf"
  double frames_per_second = 24, metres_per_unit = 1;
  std::string up_axis = "Y";
  int levels = 1;  // of gltf

  bool Contains(const std::string& name) const;
};

// --format and what belongs to it. Returns --format.
CLI::Option* AddFormatFlags(SequenceFormats* formats, CLI::App* command);

// NNNN.ply of every fitted frame in `frames_folder`, sequence.usda and sequence.glb in `folder`, as
// asked for. Errors as WriteMesh, WriteUsd and WriteGltf.
absl::Status WriteSequence(const SequenceFormats& formats, const ControlMesh& cage,
                           const std::vector<FrameRecord>& frames, const std::string& folder,
                           const std::string& frames_folder);

// What results depend on.
Json ToJson(const SequenceFormats& formats);

}  // namespace cagefit::client

#endif  // CAGEFIT_CLIENT_COMMANDS_SEQUENCE_FORMATS_H_
