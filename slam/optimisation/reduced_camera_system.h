// The normal equations of a bundle adjustment after the points are eliminated: symmetric, in
// blocks of 6 x 6 where two poses share a point.
#ifndef CORBSLAM_SLAM_OPTIMISATION_REDUCED_CAMERA_SYSTEM_H_
#define CORBSLAM_SLAM_OPTIMISATION_REDUCED_CAMERA_SYSTEM_H_

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "slam/geometry/lie.h"

namespace corbslam {

// Holds the pattern once and solves for many values. Not thread-safe.
class ReducedCameraSystem {
 public:
  // `pairs` are the (column, row) of the blocks of the lower triangle, sorted and unique, with
  // every diagonal block.
  ReducedCameraSystem(uint32_t poses, std::vector<std::pair<uint32_t, uint32_t>> pairs);
  ~ReducedCameraSystem();

  size_t blocks() const { return pairs_.size(); }
  // Returns the index of a block; both poses share a point or are the same, row >= column.
  uint32_t BlockIndex(uint32_t row, uint32_t column) const;

  // Solves blocks * step = right_side; returns false where the matrix is not positive definite.
  bool Solve(const std::vector<Matrix6d>& blocks, const Eigen::VectorXd& right_side,
             Eigen::VectorXd& step);

 private:
  bool SolveDense(const std::vector<Matrix6d>& blocks, const Eigen::VectorXd& right_side,
                  Eigen::VectorXd& step);
  bool SolveSparse(const std::vector<Matrix6d>& blocks, const Eigen::VectorXd& right_side,
                   Eigen::VectorXd& step);
  void MakePattern();

  uint32_t poses_;
  std::vector<std::pair<uint32_t, uint32_t>> pairs_;
  // Blocks of column c are pairs_[column_begin_[c], column_begin_[c + 1]).
  std::vector<uint32_t> column_begin_;
  bool is_dense_;
  Eigen::MatrixXd dense_;
  Eigen::SparseMatrix<double> sparse_;
  // CHOLMOD's factorisation, with supernodes: two to three times as fast as Eigen's own at 540 to
  // 1,200 poses (docs/adr/0002-bundle-adjustment-solver.md). It has up to four OpenMP threads of
  // its own, whatever the solver's number is; the bits are the same.
  struct SparseCholesky;
  std::unique_ptr<SparseCholesky> cholesky_;
};

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_OPTIMISATION_REDUCED_CAMERA_SYSTEM_H_
