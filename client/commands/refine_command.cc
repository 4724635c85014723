#include <iostream>
#include <memory>
#include <string>

#include "client/commands/command.h"
#include "client/io/geometry_file.h"
#include "core/base/status.h"
#include "core/subdiv/shaded_mesh.h"

namespace cagefit::client {
namespace {

constexpr int kMostLevels = 6;

struct RefineArguments {
  std::string cage, out;
  int levels = 3;
};

absl::Status Refine(const RefineArguments& arguments) {
  ASSIGN_OR_RETURN(const ControlMesh cage, ReadControlMesh(arguments.cage));
  const ShadedMesh shaded(cage, arguments.levels);
  Points3d positions;
  CornerNormals normals;
  shaded.Evaluate(cage.vertices(), &positions, &normals.values);
  normals.indices = shaded.triangles();
  TriangleMesh mesh;
  mesh.vertices.resize(3, shaded.limit_triangles().maxCoeff() + 1);
  mesh.triangles = shaded.limit_triangles();
  for (Eigen::Index k = 0; k < positions.cols(); ++k) {
    mesh.vertices.col(shaded.limit_vertices()[k]) = positions.col(k);
  }
  RETURN_IF_ERROR(WriteMesh(arguments.out, mesh, normals));
  std::cout << arguments.out << ": " << mesh.vertices.cols() << " vertices, "
            << mesh.triangles.cols() << " triangles on the limit surface\n";
  return absl::OkStatus();
}

}  // namespace

void AddRefineCommand(CLI::App* app, Run* run) {
  const auto arguments = std::make_shared<RefineArguments>();
  CLI::App* command =
      app->add_subcommand("refine", "Write the limit surface of a control mesh as a fine mesh");
  command->add_option("CAGE", arguments->cage, "Control mesh")->required();
  command
      ->add_option("--out", arguments->out,
                   "Mesh to write: .obj .ply (these with normals) .off .stl .drc")
      ->required();
  command
      ->add_option("--levels", arguments->levels,
                   "Refinement levels; each takes 4 times the triangles")
      ->capture_default_str()
      ->check(CLI::Range(0, kMostLevels));
  command->callback([arguments, run] {
    *run = [arguments] {
      const absl::Status status = Refine(*arguments);
      if (status.ok()) return static_cast<int>(kDone);
      Report(status);
      return static_cast<int>(kFailed);
    };
  });
}

}  // namespace cagefit::client
