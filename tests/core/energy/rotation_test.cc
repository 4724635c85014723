#include "core/energy/rotation.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/SVD>
#include <random>

namespace cagefit {
namespace {

Eigen::Matrix3d RandomMatrix(std::mt19937* random) {
  std::normal_distribution<double> normal;
  return Eigen::Matrix3d::NullaryExpr([&] { return normal(*random); });
}

// Textbook solution by the SVD.
Eigen::Matrix3d Oracle(const Eigen::Matrix3d& C) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(C, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const double sign = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0 ? -1 : 1;
  return svd.matrixU() * Eigen::Vector3d(1, 1, sign).asDiagonal() * svd.matrixV().transpose();
}

TEST(BestRotationTest, AgreesWithTheSvdFromAnyGuess) {
  std::mt19937 random(1);
  for (int q = 0; q < 1000; ++q) {
    const Eigen::Matrix3d C = RandomMatrix(&random);
    const Eigen::Matrix3d guess = Eigen::Quaterniond::UnitRandom().toRotationMatrix();
    const Eigen::Matrix3d R = BestRotation(C, guess);
    EXPECT_NEAR(R.determinant(), 1, 1e-12);
    EXPECT_NEAR((R.transpose() * C).trace(), (Oracle(C).transpose() * C).trace(), 1e-10);
  }
}

TEST(BestRotationTest, IsUniqueForAFlatOneRing) {
  std::mt19937 random(2);
  for (int q = 0; q < 200; ++q) {
    const Eigen::Matrix3d true_rotation = Eigen::Quaterniond::UnitRandom().toRotationMatrix();
    Eigen::Matrix3d M = RandomMatrix(&random);
    M.row(2).setZero();  // rest edges in the plane z = 0
    const Eigen::Matrix3d C = true_rotation * M * M.transpose();
    EXPECT_NEAR((BestRotation(C, Eigen::Matrix3d::Identity()) - true_rotation).norm(), 0, 1e-9);
  }
}

TEST(BestRotationTest, KeepsTheGuessWhenThereIsNothingToAlign) {
  const Eigen::Matrix3d guess = Eigen::Quaterniond::UnitRandom().toRotationMatrix();
  EXPECT_EQ(BestRotation(Eigen::Matrix3d::Zero(), guess), guess);
}

}  // namespace
}  // namespace cagefit
