// Points drawn uniformly by area from a triangle mesh [osada2002].
#ifndef CAGEFIT_CORE_MESH_AREA_SAMPLER_H_
#define CAGEFIT_CORE_MESH_AREA_SAMPLER_H_

#include <vector>

#include "core/base/random.h"
#include "core/base/types.h"

namespace cagefit {

class AreaSampler {
 public:
  AreaSampler(const Points3d& vertices, const Triangles& triangles);

  bool has_area() const { return !cumulative_.empty() && cumulative_.back() > 0; }

  struct Point {
    int64_t triangle;
    Eigen::Vector3d weights;  // barycentric
  };
  // Requires has_area(). Takes three numbers from `random`.
  Point Draw(Random* random) const;
  // The same in the triangle where the running sum of the areas passes `share` (0 to 1) of all.
  // Takes two numbers.
  Point DrawAt(double share, Random* random) const;

 private:
  std::vector<double> cumulative_;  // entry f: twice the area of triangles 0 to f
};

}  // namespace cagefit

#endif  // CAGEFIT_CORE_MESH_AREA_SAMPLER_H_
