// Inverts information matrices whose rows have different units.
#ifndef CORBSLAM_SLAM_OPTIMISATION_SCALED_INVERSE_H_
#define CORBSLAM_SLAM_OPTIMISATION_SCALED_INVERSE_H_

#include <Eigen/Core>
#include <Eigen/Eigenvalues>
#include <optional>

namespace corbslam {

// Returns the inverse of a symmetric matrix; nullopt where it is singular: where, each row and
// column scaled to a diagonal of ones, its least eigenvalue is not above `min_relative` of its
// greatest, so that a direction is not determined.
template <int kSize>
std::optional<Eigen::Matrix<double, kSize, kSize>> InvertScaled(
    const Eigen::Matrix<double, kSize, kSize>& H, double min_relative) {
  using Matrix = Eigen::Matrix<double, kSize, kSize>;
  using Vector = Eigen::Matrix<double, kSize, 1>;
  const Vector diagonal = H.diagonal();
  if (!(diagonal.minCoeff() > 0) || !diagonal.allFinite()) return std::nullopt;
  const Vector unit = diagonal.cwiseSqrt().cwiseInverse();
  const Matrix scaled = unit.asDiagonal() * H * unit.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Matrix> solver(scaled);
  const Vector& values = solver.eigenvalues();
  if (!(values.minCoeff() > min_relative * values.maxCoeff())) return std::nullopt;
  const Matrix inverse = solver.eigenvectors() * values.cwiseInverse().asDiagonal() *
                         solver.eigenvectors().transpose();
  return Matrix(unit.asDiagonal() * inverse * unit.asDiagonal());
}

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_OPTIMISATION_SCALED_INVERSE_H_
