#include "core/energy/attachments.h"

#include <gtest/gtest.h>

#include "core/base/random.h"

namespace cagefit {
namespace {

Attachments RandomAttachments(int64_t count, int64_t n, Random* random) {
  Attachments out;
  std::vector<Eigen::Triplet<double, int32_t>> entries;
  for (int32_t k = 0; k < count; ++k) {
    for (int s = 0; s < 4; ++s) {
      entries.emplace_back(k, static_cast<int32_t>(random->Uniform(0, static_cast<double>(n))),
                           random->Uniform(-1, 1));
    }
  }
  out.rows.resize(count, n);
  out.rows.setFromTriplets(entries.begin(), entries.end());
  out.targets = Points3d::NullaryExpr(3, count, [&] { return random->Uniform(-1, 1); });
  for (int64_t k = 0; k < count; ++k) {
    const Eigen::Matrix3d B = Eigen::Matrix3d::NullaryExpr([&] { return random->Uniform(-1, 1); });
    out.weights.push_back(B * B.transpose());
  }
  return out;
}

TEST(AttachmentsTest, GradientIsThatOfTheEnergy) {
  Random random(1);
  const int64_t n = 12;
  const Attachments attachments = RandomAttachments(7, n, &random);
  const Points3d V = Points3d::NullaryExpr(3, n, [&] { return random.Uniform(-1, 1); });
  Points3d half_gradient = Points3d::Zero(3, n);
  attachments.AddHalfGradient(V, &half_gradient);
  for (int64_t i = 0; i < V.size(); ++i) {
    const double step = 1e-4;  // the energy is quadratic: central differences are exact
    Points3d ahead = V, behind = V;
    ahead.data()[i] += step;
    behind.data()[i] -= step;
    EXPECT_NEAR(2 * half_gradient.data()[i],
                (attachments.Energy(ahead) - attachments.Energy(behind)) / (2 * step), 1e-9);
  }
}

TEST(AttachmentsTest, AddsToWhatIsThere) {
  Random random(2);
  const Attachments attachments = RandomAttachments(3, 5, &random);
  const Points3d V = Points3d::Random(3, 5);
  Points3d once = Points3d::Zero(3, 5), upon = Points3d::Constant(3, 5, 2.0);
  attachments.AddHalfGradient(V, &once);
  attachments.AddHalfGradient(V, &upon);
  EXPECT_NEAR((upon - once - Points3d::Constant(3, 5, 2.0)).norm(), 0, 1e-14);
}

TEST(AttachmentsTest, NoneIsNothing) {
  Attachments attachments;
  attachments.Clear();
  Points3d half_gradient = Points3d::Zero(3, 4);
  attachments.AddHalfGradient(Points3d::Ones(3, 4), &half_gradient);
  EXPECT_EQ(attachments.Energy(Points3d::Ones(3, 4)), 0);
  EXPECT_EQ(half_gradient.norm(), 0);
}

}  // namespace
}  // namespace cagefit
