#include "core/subdiv/triangle_step.h"

#include <algorithm>
#include <limits>

namespace cagefit {

TriangleStep MinimizeInTriangle(const Eigen::Vector2d& p, const Eigen::Vector2d& g,
                                const Eigen::Matrix2d& H) {
  const double determinant = H(0, 0) * H(1, 1) - H(0, 1) * H(0, 1);
  const Eigen::Vector2d free(p.x() - (H(1, 1) * g.x() - H(0, 1) * g.y()) / determinant,
                             p.y() - (H(0, 0) * g.y() - H(0, 1) * g.x()) / determinant);
  if (free.x() >= 0 && free.y() >= 0 && free.x() + free.y() <= 1) return {free, -1};

  // A convex function has its minimum over the triangle on an edge then.
  const Eigen::Vector2d corners[3] = {{0, 0}, {1, 0}, {0, 1}};
  TriangleStep best = {p, -1};
  double least = std::numeric_limits<double>::infinity();
  for (int c = 0; c < 3; ++c) {
    const Eigen::Vector2d& a = corners[c];
    const Eigen::Vector2d along = corners[(c + 1) % 3] - a, from = a - p;
    const Eigen::Vector2d slope = g + H * from;
    const double t = std::clamp(-along.dot(slope) / along.dot(H * along), 0.0, 1.0);
    const Eigen::Vector2d d = from + t * along;
    const double value = g.dot(d) + 0.5 * d.dot(H * d);
    if (value < least) {
      least = value;
      best = {a + t * along, c};
    }
  }
  return best;
}

}  // namespace cagefit
