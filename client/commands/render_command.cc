#include <iostream>
#include <memory>
#include <string>
#include <utility>

#include "absl/strings/str_cat.h"
#include "client/commands/command.h"
#include "client/commands/render_views.h"
#include "client/io/camera_file.h"
#include "client/io/file_bytes.h"
#include "client/io/geometry_file.h"
#include "client/io/image_file.h"
#include "client/io/picture.h"
#include "client/limit_surface.h"
#include "core/base/status.h"
#include "core/image/mesh_renderer.h"

namespace cagefit::client {
namespace {

constexpr int kMostLevels = 6;
constexpr int kMostViews = 10'000;
constexpr int kMostPixels = 8192;  // of a side

struct RenderArguments {
  std::string mesh, out, silhouette = "outline";
  int levels = -1;  // below 0: the mesh as it is
  int bits = 8;     // of PNG files
  ViewOptions views;
};

absl::StatusOr<TriangleMesh> ReadSurface(const RenderArguments& arguments) {
  if (arguments.levels >= 0) {
    ASSIGN_OR_RETURN(const ControlMesh cage, ReadControlMesh(arguments.mesh));
    return LimitSurface(cage, arguments.levels);
  }
  ASSIGN_OR_RETURN(Geometry geometry, ReadGeometry(arguments.mesh));
  if (!geometry.is_cloud()) return std::move(geometry.mesh);
  return absl::InvalidArgumentError(
      absl::StrCat(arguments.mesh, ": it has no faces; rendering needs them"));
}

absl::Status MakeFolders(const std::string& out) {
  for (const char* kind : {"/silhouette", "/depth", "/normals"}) {
    RETURN_IF_ERROR(MakeFolder(out + kind));
  }
  return absl::OkStatus();
}

absl::Status RenderViews(const RenderArguments& arguments) {
  ASSIGN_OR_RETURN(const TriangleMesh mesh, ReadSurface(arguments));
  ASSIGN_OR_RETURN(const std::vector<Camera> views, ChooseViews(arguments.views, mesh.vertices));
  RETURN_IF_ERROR(MakeFolders(arguments.out));
  RETURN_IF_ERROR(WriteCameras(arguments.out + "/cameras.json", views));
  SilhouetteOptions options;
  if (arguments.silhouette == "pytorch3d") options.mode = SilhouetteMode::kPytorch3d;
  for (const Camera& view : views) {
    const Rendering rendering = RenderMesh(mesh, view, options);
    const auto file = [&](const char* kind, const char* ending) {
      return absl::StrCat(arguments.out, "/", kind, "/", view.name, ending);
    };
    const int bits = arguments.bits;
    RETURN_IF_ERROR(WritePng(file("silhouette", ".png"), rendering.silhouette, bits));
    RETURN_IF_ERROR(WritePng(file("depth", ".png"), DepthPicture(rendering.depth), bits));
    RETURN_IF_ERROR(WritePng(file("normals", ".png"), NormalPicture(rendering.normals), bits));
    RETURN_IF_ERROR(WritePfm(file("depth", ".pfm"), rendering.depth));
    RETURN_IF_ERROR(WritePfm(file("normals", ".pfm"), rendering.normals));
  }
  std::cout << arguments.out << ": silhouette, depth and normals of " << mesh.triangles.cols()
            << " triangles in " << views.size() << " views\n";
  return absl::OkStatus();
}

}  // namespace

void AddRenderCommand(CLI::App* app, Run* run) {
  const auto arguments = std::make_shared<RenderArguments>();
  ViewOptions* views = &arguments->views;
  CLI::App* command = app->add_subcommand("render",
                                          "Write silhouettes (PNG), depths and normals in world "
                                          "coordinates (PFM, and PNG to look at) of a "
                                          "mesh or a limit surface, and the cameras that saw them");
  command->add_option("MESH", arguments->mesh, "Mesh, or with --levels control mesh")->required();
  command->add_option("--out", arguments->out, "Folder to write to")->required();
  command
      ->add_option("--levels", arguments->levels,
                   "Render the limit surface of a control mesh, refined so often")
      ->check(CLI::Range(0, kMostLevels));
  CLI::Option* cameras = command->add_option("--cameras", views->cameras,
                                             "Cameras: a JSON file, or a folder with COLMAP's text "
                                             "model. Their lenses' distortion is left "
                                             "out. Without: virtual cameras around the mesh");
  command->add_option("--layout", views->layout, "Where virtual cameras stand: sphere or tutorial")
      ->capture_default_str()
      ->check(CLI::IsMember({"sphere", "tutorial"}))
      ->excludes(cameras);
  command->add_option("--views", views->count, "Virtual cameras")
      ->capture_default_str()
      ->check(CLI::Range(1, kMostViews))
      ->excludes(cameras);
  command
      ->add_option("--size", views->size,
                   "Pixels of the longer side; default: the camera's own, of virtual ones 256")
      ->check(CLI::Range(1, kMostPixels));
  command->add_option("--bits", arguments->bits, "Of a PNG file's values: 8 or 16")
      ->capture_default_str()
      ->check(CLI::IsMember({8, 16}));
  command
      ->add_option("--silhouette", arguments->silhouette,
                   "outline, or pytorch3d for the image that PyTorch3D makes")
      ->capture_default_str()
      ->check(CLI::IsMember({"outline", "pytorch3d"}));
  command->callback([arguments, run] {
    *run = [arguments] {
      const absl::Status status = RenderViews(*arguments);
      if (status.ok()) return static_cast<int>(kDone);
      Report(status);
      return static_cast<int>(kFailed);
    };
  });
}

}  // namespace cagefit::client
