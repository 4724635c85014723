#include "core/fit/frame_images.h"

#include <algorithm>
#include <utility>

#include "core/base/parallel.h"
#include "core/base/status.h"
#include "core/image/mask_target.h"
#include "core/image/views.h"

namespace cagefit {

namespace {

std::vector<Camera> VirtualCameras(const PointCloud& cloud, const ImageOptions& options) {
  const Box box = BoundingBox(cloud.points);
  const Eigen::Vector3d center = 0.5 * (box.min + box.max);
  if (options.views == Views::kTutorial) {
    return TutorialViews(options.view_count, center, box.size().maxCoeff(), options.size);
  }
  return SphereViews(options.view_count, center, 0.5 * box.diagonal(), options.size);
}

}  // namespace

SilhouetteOptions RenderOptions(const ImageOptions& options) {
  return {options.mode, {options.sigma, options.blur_radius, options.faces_per_pixel}};
}

absl::Status FrameImages::Build(const FrameSource& source, const PointCloud& cloud, double spacing,
                                const Normalization& normalization, const ImageOptions& options) {
  targets_.clear();
  if (options.views == Views::kNone) return absl::OkStatus();
  if (options.views == Views::kCameras) {
    return BuildFromMasks(source, normalization, options);
  }
  const std::vector<Camera> cameras = VirtualCameras(cloud, options);
  targets_.resize(cameras.size());
  if (source.mesh != nullptr) {
    BuildFromMesh(*source.mesh, normalization, cameras, options);
  } else {
    BuildFromCloud(cloud, spacing, cameras, options);
  }
  return absl::OkStatus();
}

absl::Status FrameImages::BuildFromMasks(const FrameSource& source,
                                         const Normalization& normalization,
                                         const ImageOptions& options) {
  if (source.cameras == nullptr || source.masks == nullptr) return absl::OkStatus();
  for (size_t k = 0; k < source.masks->size(); ++k) {
    const Image& mask = (*source.masks)[k];
    if (mask.empty()) continue;
    ASSIGN_OR_RETURN(ImageTarget target,
                     MaskTarget(mask, (*source.cameras)[k], options.size, options.sigma));
    target.slack = options.calibration_error * target.camera.width / (*source.cameras)[k].width;
    target.camera = InCoordinates(target.camera, normalization.center, normalization.scale);
    targets_.push_back(std::move(target));
  }
  return absl::OkStatus();
}

void FrameImages::BuildFromMesh(const TriangleMesh& mesh, const Normalization& normalization,
                                const std::vector<Camera>& cameras, const ImageOptions& options) {
  const Points3d vertices = normalization.ToUnit(mesh.vertices);
  const bool has_surfaces = options.depth_weight > 0 || options.normal_weight > 0;
  const Surfaces surfaces = has_surfaces ? Surfaces::kVisible : Surfaces::kHidden;
  const MeshEdges edges(mesh.triangles);
  ParallelFor(static_cast<int64_t>(cameras.size()), 1, [&](int64_t begin, int64_t end) {
    for (int64_t k = begin; k < end; ++k) {
      MeshView view;
      view.Render(vertices, mesh.triangles, edges, cameras[k], RenderOptions(options), surfaces);
      ImageTarget& target = targets_[k];
      target.camera = cameras[k];
      target.silhouette = view.silhouette();
      if (has_surfaces) {
        target.depth = DepthImage(view.depths());
        target.normals = NormalImage(view.depths(), vertices, mesh.triangles, cameras[k]);
      }
    }
  });
}

void FrameImages::BuildFromCloud(const PointCloud& cloud, double spacing,
                                 const std::vector<Camera>& cameras, const ImageOptions& options) {
  splatters_.resize(cameras.size());
  const bool surfaces = options.depth_weight > 0 || options.normal_weight > 0;
  const SplatImages images = surfaces ? SplatImages::kAll : SplatImages::kSilhouette;
  ParallelFor(static_cast<int64_t>(cameras.size()), 1, [&](int64_t begin, int64_t end) {
    for (int64_t k = begin; k < end; ++k) {
      splatters_[k].Splat(cloud, spacing, cameras[k], &targets_[k], options.sigma, images);
    }
  });
}

}  // namespace cagefit
