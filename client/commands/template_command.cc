#include <iostream>
#include <memory>
#include <string>

#include "absl/strings/str_cat.h"
#include "client/commands/command.h"
#include "client/io/geometry_file.h"
#ifdef CAGEFIT_WITH_TEMPLATE
#include "core/base/status.h"
#include "core/cloud/normals.h"
#include "core/template/template_maker.h"
#endif

namespace cagefit::client {
namespace {

struct TemplateArguments {
  std::string input, out;
  int32_t vertices = 0;
  double crease_angle = -1;  // degrees; negative: not given
  std::vector<double> sensor;
};

#ifdef CAGEFIT_WITH_TEMPLATE

absl::StatusOr<ControlMesh> Make(const TemplateArguments& arguments, TemplateReport* report) {
  ASSIGN_OR_RETURN(const Geometry geometry, ReadGeometry(arguments.input));
  TemplateOptions options;
  options.vertices = arguments.vertices;
  if (arguments.crease_angle >= 0) options.crease_angle = arguments.crease_angle;
  options.tags = geometry.tags;
  if (!geometry.is_cloud()) return TemplateFromMesh(geometry.mesh, options, report);
  PointCloud cloud = ToCloud(geometry);
  RETURN_IF_ERROR(ValidateTarget(cloud));
  if (!cloud.has_normals()) {
    NormalOptions normals;
    if (!arguments.sensor.empty()) {
      normals.sensor =
          Eigen::Vector3d(arguments.sensor[0], arguments.sensor[1], arguments.sensor[2]);
    }
    RETURN_IF_ERROR(EstimateNormals(normals, &cloud));
  }
  return TemplateFromCloud(cloud, options, report);
}

int MakeTemplate(const TemplateArguments& arguments) {
  TemplateReport report;
  const auto cage = Make(arguments, &report);
  if (!cage.ok()) {
    return Report(absl::Status(cage.status().code(),
                               absl::StrCat(arguments.input, ": ", cage.status().message())));
  }
  const absl::Status written = WriteControlMesh(arguments.out, *cage);
  if (!written.ok()) {
    Report(written);
    return kFailed;
  }
  std::cout << arguments.out << ": " << cage->vertex_count() << " control vertices, "
            << cage->triangles().cols() << " triangles, " << report.components_kept
            << (report.components_kept == 1 ? " part, " : " parts, ") << report.boundary_loops
            << " boundary loops, " << report.crease_edges << " crease edges\n";
  if (report.components_dropped > 0) {
    std::cerr << "cagefit: left out " << report.components_dropped << " small parts\n";
  }
  return kDone;
}

#else

int MakeTemplate(const TemplateArguments&) {
  std::cerr << "cagefit: this build makes no templates: it was configured with "
               "CAGEFIT_WITH_TEMPLATE=OFF\n";
  return kWrongUsage;
}

#endif

}  // namespace

void AddTemplateCommand(CLI::App* app, Run* run) {
  const auto arguments = std::make_shared<TemplateArguments>();
  CLI::App* command = app->add_subcommand("template", "Make a control mesh from a mesh or a cloud");
  command->add_option("INPUT", arguments->input, "Mesh or cloud")->required();
  command->add_option("--vertices", arguments->vertices, "Control vertices, within 1 %")
      ->required();
  command->add_option("--out", arguments->out, "Control mesh to write (.obj)")->required();
  command
      ->add_option(
          "--crease-angle", arguments->crease_angle,
          "Degrees from which an edge of a mesh starts a crease; 0: none; default: 40, and "
          "only where the creases look like a part's")
      ->check(CLI::Range(0.0, 180.0));
  command
      ->add_option("--sensor", arguments->sensor,
                   "X Y Z: position that normals look at, for a cloud without normals; default: "
                   "outwards")
      ->expected(3);
  command->callback([arguments, run] { *run = [arguments] { return MakeTemplate(*arguments); }; });
}

}  // namespace cagefit::client
