// Images of a triangle mesh: silhouette, depth, normals.
#ifndef CAGEFIT_CORE_IMAGE_MESH_RENDERER_H_
#define CAGEFIT_CORE_IMAGE_MESH_RENDERER_H_

#include "core/image/camera.h"
#include "core/image/depth_buffer.h"
#include "core/image/image.h"
#include "core/image/mesh_edges.h"
#include "core/image/outline_silhouette.h"
#include "core/image/soft_silhouette.h"
#include "core/mesh/triangle_mesh.h"

namespace cagefit {

enum class SilhouetteMode {
  kOutline,    // outline_silhouette.h
  kPytorch3d,  // soft_silhouette.h
};

enum class Surfaces { kHidden, kVisible };

struct SilhouetteOptions {
  SilhouetteMode mode = SilhouetteMode::kOutline;
  SoftSilhouetteOptions soft;  // of these, kOutline takes sigma
};

// What one camera sees of a mesh whose vertices move. Not thread-safe; buffers keep their capacity.
class MeshView {
 public:
  // Renders the silhouette (width x height of the camera, whose distortion is left out) of
  // `vertices` (3 x n). `edges` are those of `triangles`; both must stay as they are until the last
  // call for this rendering. With Surfaces::kVisible the nearest triangles, too.
  void Render(const Points3d& vertices, const Triangles& triangles, const MeshEdges& edges,
              const Camera& camera, const SilhouetteOptions& options,
              Surfaces surfaces = Surfaces::kHidden);

  const Image& silhouette() const { return silhouette_; }
  const DepthBuffer& depths() const { return depths_; }  // with Surfaces::kVisible
  const ProjectedMesh& projected() const { return projected_; }
  // Of the last rendering in kOutline.
  const OutlineSilhouette& outline() const { return outline_; }

  // Adds dE/dV (3 x n) given dE/dA at the last rendering.
  void AddGradient(const Image& by_silhouette, Points3d* gradient);

 private:
  const Points3d* vertices_ = nullptr;
  const Triangles* triangles_ = nullptr;
  const MeshEdges* edges_ = nullptr;
  Camera camera_;
  SilhouetteMode mode_ = SilhouetteMode::kOutline;
  ProjectedMesh projected_;
  TriangleTiles tiles_;
  DepthBuffer depths_;
  OutlineSilhouette outline_;
  SoftSilhouette soft_;
  Image silhouette_;
  Points2d by_pixel_;
};

// Depth z of the nearest surface, 0 where there is none.
Image DepthImage(const DepthBuffer& depths);

// Unit normals of the nearest triangles, in world coordinates, turned towards the camera; 0 where
// there is none. Three channels.
Image NormalImage(const DepthBuffer& depths, const Points3d& vertices, const Triangles& triangles,
                  const Camera& camera);

struct Rendering {
  Image silhouette, depth, normals;
};
// All three of a mesh that does not move. Requires a valid camera and triangle indices in range.
Rendering RenderMesh(const TriangleMesh& mesh, const Camera& camera,
                     const SilhouetteOptions& options = {});

}  // namespace cagefit

#endif  // CAGEFIT_CORE_IMAGE_MESH_RENDERER_H_
