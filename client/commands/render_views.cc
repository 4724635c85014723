#include "client/commands/render_views.h"

#include <algorithm>
#include <set>

#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/strip.h"
#include "client/io/camera_file.h"
#include "core/base/status.h"
#include "core/image/views.h"

namespace cagefit::client {
namespace {

constexpr int kVirtualSize = 256;

std::string FileName(absl::string_view name) {
  for (const absl::string_view ending : {".png", ".jpg", ".jpeg", ".tif", ".tiff", ".bmp"}) {
    if (!absl::EndsWithIgnoreCase(name, ending)) continue;
    name.remove_suffix(ending.size());
    break;
  }
  std::string file(name);
  for (char& c : file) {
    if (!absl::ascii_isalnum(c) && c != '.' && c != '_' && c != '-') c = '_';
  }
  // Neither hidden nor a way out of the folder.
  if (!file.empty() && file[0] == '.') file[0] = '_';
  return file;
}

absl::StatusOr<std::vector<Camera>> VirtualViews(const ViewOptions& options,
                                                 const Points3d& vertices) {
  const Box box = BoundingBox(vertices);
  const Eigen::Vector3d center = 0.5 * (box.min + box.max);
  if (box.empty() || !(box.diagonal() > 0)) {
    return absl::InvalidArgumentError(
        "the mesh has no extent: virtual cameras have nothing to see");
  }
  const int size = options.size > 0 ? options.size : kVirtualSize;
  if (options.layout == "tutorial") {
    return TutorialViews(options.count, center, box.size().maxCoeff(), size);
  }
  const double radius = (vertices.colwise() - center).colwise().norm().maxCoeff();
  return SphereViews(options.count, center, radius, size);
}

absl::StatusOr<std::vector<Camera>> GivenViews(const ViewOptions& options) {
  ASSIGN_OR_RETURN(std::vector<Camera> views, ReadCameras(options.cameras));
  for (Camera& view : views) {
    if (options.size > 0) view = Resized(view, options.size);
    view.name = FileName(view.name);
    view.distortion = Distortion();
  }
  return views;
}

}  // namespace

absl::StatusOr<std::vector<Camera>> ChooseViews(const ViewOptions& options,
                                                const Points3d& vertices) {
  ASSIGN_OR_RETURN(std::vector<Camera> views,
                   options.cameras.empty() ? VirtualViews(options, vertices) : GivenViews(options));
  std::set<std::string> names;
  for (size_t k = 0; k < views.size(); ++k) {
    if (views[k].name.empty()) views[k].name = absl::StrFormat("view_%04d", k);
    if (names.insert(views[k].name).second) continue;
    return absl::InvalidArgumentError(absl::StrCat(
        options.cameras, ": two cameras would write to files of the name ", views[k].name));
  }
  return views;
}

}  // namespace cagefit::client
