#include "slam/exchange/overlap.h"

#include <gtest/gtest.h>

#include <limits>

namespace corbslam {
namespace {

TEST(IsCovarianceTest, WantsFiniteSymmetricAndNothingBelowZero) {
  EXPECT_TRUE(IsCovariance(Matrix7d::Zero()));
  EXPECT_TRUE(IsCovariance(Matrix7d::Identity()));
  // The matrix has one direction alone, with what rounding leaves of it.
  const Vector7d direction = (Vector7d() << 1, -2, 3, 0.1, 0.2, -0.3, 0).finished();
  EXPECT_TRUE(IsCovariance(direction * direction.transpose()));
  Matrix7d matrix = Matrix7d::Identity();
  matrix(2, 2) = -0.1;
  EXPECT_FALSE(IsCovariance(matrix));
  // Two components are correlated by more than one.
  matrix = Matrix7d::Identity();
  matrix(0, 3) = matrix(3, 0) = 1.5;
  EXPECT_FALSE(IsCovariance(matrix));
  matrix = Matrix7d::Identity();
  matrix(0, 3) = 0.5;
  EXPECT_FALSE(IsCovariance(matrix));
  matrix(3, 0) = 0.5;
  EXPECT_TRUE(IsCovariance(matrix));
  for (const double value :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    matrix(4, 4) = value;
    EXPECT_FALSE(IsCovariance(matrix)) << value;
  }
}

}  // namespace
}  // namespace corbslam
