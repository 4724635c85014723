// The outline of the region that scattered points of an image cover.
//
// The region is the morphological closing of the points P by disks of radius r: grown by r, then
// shrunk by r,
//
//   D(x) = min_p |x - p|,   E(x) = distance from x to {D >= r},   region = {E >= r}
//
// so that gaps narrower than 2 r close while the points at the rim stay on it: nothing is dilated.
// Gaps that are left by chance are told from real ones by their size: a hole or bay of {D > r}
// stays only where somewhere D > hole_radius, to a third of a pixel.
//
// D is exact at the nodes of a grid of half pixels, its contour linear between them, and E exact
// for that contour.
#ifndef CAGEFIT_CORE_IMAGE_POINT_OUTLINE_H_
#define CAGEFIT_CORE_IMAGE_POINT_OUTLINE_H_

#include <cstdint>
#include <vector>

#include "core/image/image.h"
#include "core/image/outline.h"
#include "core/image/outline_distance.h"
#include "core/image/pixel_buckets.h"

namespace cagefit {

struct ClosingRadii {
  double radius = 1;       // pixels, at least 1
  double hole_radius = 1;  // pixels, at least radius
};

// Buffers keep their capacity from call to call.
class PointOutline {
 public:
  // Pixels beyond the image as far as which points count, so that the outline does not know where
  // the image ends.
  static int Margin(const ClosingRadii& radii);

  // Points (u[i], v[i]) in pixels; those that are not numbers are left out.
  void Build(const std::vector<float>& u, const std::vector<float>& v, int width, int height,
             const ClosingRadii& radii);

  // In pixels of the image; goes on beyond its border.
  const Outline& outline() const { return outline_; }
  // 1 at pixels whose centre the region holds, else 0; width x height.
  const Image& inside() const { return inside_; }
  // Holds the region; may leave the image.
  const PixelWindow& window() const { return window_; }

 private:
  // In the units of the nodes.
  void Sort(const std::vector<float>& u, const std::vector<float>& v, int width, int height,
            int margin);
  void MeasureCells(double reach);
  void MeasureNodes(double radius);
  float DistanceAt(int x, int y, float at_least, float at_most) const;
  void FillHoles(double radius, double hole_radius);
  void Erode(double radius);
  void ReadInside(int width, int height);

  PixelWindow window_;
  PixelBuckets cells_;
  std::vector<float> sorted_x_, sorted_y_;  // of the points, from the window's first node
  std::vector<float> column_;
  Image nodes_;  // D, then E - r
  std::vector<int32_t> stack_;
  std::vector<uint8_t> kept_;
  Outline grown_, outline_;
  OutlineDistance to_grown_;
  Image inside_;
};

}  // namespace cagefit

#endif  // CAGEFIT_CORE_IMAGE_POINT_OUTLINE_H_
