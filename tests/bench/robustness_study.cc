// Fits to a spoiled bunny, measured against the clean one.
#include <Eigen/Geometry>
#include <cstdio>
#include <vector>

#include "core/base/random.h"
#include "tests/bench/study.h"
#include "tests/support/spoiled_cloud.h"

namespace cagefit::bench {
namespace {

constexpr int32_t kVertices = 2000;
constexpr int kPatches = 12;

struct Holes {
  PointCloud rest;
  Points3d kept_far;  // of the clean points those not near a hole
};

// Takes `share` of the points, as kPatches balls around points of the cloud.
Holes WithHoles(const PointCloud& cloud, double share) {
  Random random(4);
  std::vector<Eigen::Vector3f> centres;
  centres.reserve(kPatches);
  for (int k = 0; k < kPatches; ++k) {
    centres.push_back(cloud.points.col(
        static_cast<int64_t>(random.Uniform() * static_cast<double>(cloud.size()))));
  }
  std::vector<float> distance(cloud.size());
  for (int64_t i = 0; i < cloud.size(); ++i) {
    float least = 1e30f;
    for (const Eigen::Vector3f& c : centres)
      least = std::min(least, (cloud.points.col(i) - c).norm());
    distance[i] = least;
  }
  std::vector<float> sorted = distance;
  const auto rank =
      sorted.begin() + static_cast<int64_t>(share * static_cast<double>(cloud.size()));
  std::nth_element(sorted.begin(), rank, sorted.end());
  const float radius = *rank, margin = 0.02f * static_cast<float>(testing::Diagonal(cloud));
  Holes holes;
  std::vector<int64_t> rest, far;
  for (int64_t i = 0; i < cloud.size(); ++i) {
    if (distance[i] > radius) rest.push_back(i);
    if (distance[i] > radius + margin) far.push_back(i);
  }
  holes.rest.points = cloud.points(Eigen::all, rest);
  holes.rest.normals = cloud.normals(Eigen::all, rest);
  holes.kept_far = cloud.points(Eigen::all, far).cast<double>();
  return holes;
}

class Study {
 public:
  Study()
      : clean_(LoadModel("static/bunny_closed_34835.ply")), cage_(CageOf(clean_.mesh, kVertices)) {
    std::printf(
        "| %s with | RMS, %%, template of the clean mesh | RMS, %%, template of the cloud itself "
        "|\n"
        "| --- | ---: | ---: |\n",
        clean_.name.c_str());
  }

  void Row(const char* what, const PointCloud& target, const Points3d* where = nullptr) const {
    std::printf("| %s | %.4f |", what, Rms(FitTo(target, cage_), where));
    std::fflush(stdout);
    std::printf(" %.4f |\n", Rms(FitTo(target, CageOf(target, kVertices)), where));
  }

  // Of fits from cages that were moved.
  void MovedRow(const char* what, double scale, double degrees, double shift) const {
    const Box box = BoundingBox(clean_.cloud.points);
    const Eigen::Vector3d centre = (box.min + box.max) / 2;
    const Eigen::Vector3d direction = Eigen::Vector3d(1, 2, 2) / 3, axis(0, 0.6, 0.8);
    const Eigen::Matrix3d turn =
        scale * Eigen::AngleAxisd(degrees * M_PI / 180, axis).toRotationMatrix();
    const Points3d moved = (turn * (cage_.vertices().colwise() - centre)).colwise() +
                           (centre + shift * box.diagonal() * direction);
    std::printf("| %s | %.4f | |\n", what,
                Rms(FitTo(clean_.cloud, cage_.WithVertices(moved)), nullptr));
    std::fflush(stdout);
  }

  const PointCloud& cloud() const { return clean_.cloud; }

 private:
  // Both ways to the clean mesh, or from the points alone.
  double Rms(const StudyFit& fit, const Points3d* where) const {
    const SurfaceMetrics metrics = CompareToMesh(fit.surface, clean_.mesh);
    if (where == nullptr) return metrics.Percent(metrics.symmetric_rms());
    const TriangleBvh bvh(fit.surface.vertices, fit.surface.triangles);
    return metrics.Percent(DistancesToSurface(*where, bvh).rms);
  }

  const Model clean_;
  const ControlMesh cage_;
};

}  // namespace

void StudyRobustness() {
  const Study study;
  const PointCloud& clean = study.cloud();
  study.Row("nothing", clean);
  study.Row("1 % noise", testing::WithNoise(clean, 0.01));
  study.Row("10 % outliers", testing::WithOutliers(clean, 0.1));
  const Holes holes = WithHoles(clean, 0.3);
  study.Row("30 % missing in patches, away from them", holes.rest, &holes.kept_far);
  study.Row("5 % of normals turned", testing::WithFlippedNormals(clean, 0.05));
  study.MovedRow("template shifted by 30 % of the diagonal", 1, 0, 0.3);
  study.MovedRow("template scaled by 1.3", 1.3, 0, 0);
  study.MovedRow("template scaled by 0.7", 0.7, 0, 0);
  study.MovedRow("template turned by 20 degrees", 1, 20, 0);
  study.MovedRow("template shifted, scaled by 1.3 and turned", 1.3, 20, 0.3);
}

}  // namespace cagefit::bench
