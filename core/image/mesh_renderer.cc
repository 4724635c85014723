#include "core/image/mesh_renderer.h"

#include <Eigen/Geometry>
#include <cmath>

#include "core/image/silhouette_image.h"

namespace cagefit {

void MeshView::Render(const Points3d& vertices, const Triangles& triangles, const MeshEdges& edges,
                      const Camera& camera, const SilhouetteOptions& options, Surfaces surfaces) {
  vertices_ = &vertices;
  triangles_ = &triangles;
  edges_ = &edges;
  camera_ = camera;
  mode_ = options.mode;
  ProjectMesh(vertices, camera, &projected_);
  const double reach = SilhouetteReach(options.soft.sigma, camera.half_side());
  const int pad = static_cast<int>(std::ceil(reach)) + 1;
  tiles_.Build(projected_, triangles, camera.width, camera.height, /*margin=*/0, pad);
  if (surfaces == Surfaces::kVisible) {
    depths_.Render(projected_, triangles, tiles_, camera.width, camera.height);
  }
  if (mode_ == SilhouetteMode::kOutline) {
    outline_.Render(projected_, triangles, edges, tiles_, camera.width, camera.height,
                    options.soft.sigma, &silhouette_);
  } else {
    soft_.Render(projected_, triangles, camera.width, camera.height, options.soft, &silhouette_);
  }
}

void MeshView::AddGradient(const Image& by_silhouette, Points3d* gradient) {
  by_pixel_.setZero(2, vertices_->cols());
  if (mode_ == SilhouetteMode::kOutline) {
    outline_.AddGradient(*edges_, by_silhouette, &by_pixel_);
  } else {
    soft_.AddGradient(*triangles_, by_silhouette, &by_pixel_);
  }
  AddVertexGradient(*vertices_, camera_, by_pixel_, gradient);
}

Image DepthImage(const DepthBuffer& depths) {
  Image out(depths.width(), depths.height());
  for (int y = 0; y < out.height; ++y) {
    for (int x = 0; x < out.width; ++x) {
      if (depths.IsCovered(x, y)) *out.at(x, y) = static_cast<float>(depths.depth(x, y));
    }
  }
  return out;
}

Image NormalImage(const DepthBuffer& depths, const Points3d& vertices, const Triangles& triangles,
                  const Camera& camera) {
  Image out(depths.width(), depths.height(), 3);
  const Eigen::Vector3d eye = camera.center();
  for (int y = 0; y < out.height; ++y) {
    for (int x = 0; x < out.width; ++x) {
      const int32_t f = depths.triangle(x, y);
      if (f == DepthBuffer::kNone) continue;
      const Eigen::Vector3d a = vertices.col(triangles(0, f));
      Eigen::Vector3d normal =
          (vertices.col(triangles(1, f)) - a).cross(vertices.col(triangles(2, f)) - a).normalized();
      if (normal.dot(eye - a) < 0) normal = -normal;
      for (int c = 0; c < 3; ++c) out.at(x, y)[c] = static_cast<float>(normal[c]);
    }
  }
  return out;
}

Rendering RenderMesh(const TriangleMesh& mesh, const Camera& camera,
                     const SilhouetteOptions& options) {
  MeshView view;
  const MeshEdges edges(mesh.triangles);
  view.Render(mesh.vertices, mesh.triangles, edges, camera, options, Surfaces::kVisible);
  return {view.silhouette(), DepthImage(view.depths()),
          NormalImage(view.depths(), mesh.vertices, mesh.triangles, camera)};
}

}  // namespace cagefit
