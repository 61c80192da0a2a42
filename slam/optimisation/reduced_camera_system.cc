#include "slam/optimisation/reduced_camera_system.h"

#include <Eigen/Cholesky>
#include <Eigen/CholmodSupport>
#include <algorithm>

namespace corbslam {
namespace {

// Dense factorisation is faster below this many poses, or where most blocks are there.
constexpr uint32_t kAlwaysDensePoses = 40;
constexpr uint32_t kMaxDensePoses = 400;
constexpr double kDenseShare = 0.3;

}  // namespace

struct ReducedCameraSystem::SparseCholesky {
  // A matrix that is not positive definite is said in a result, not on the standard output.
  SparseCholesky() { llt.cholmod().print = 0; }

  Eigen::CholmodSupernodalLLT<Eigen::SparseMatrix<double>, Eigen::Lower> llt;
};

ReducedCameraSystem::~ReducedCameraSystem() = default;

ReducedCameraSystem::ReducedCameraSystem(uint32_t poses,
                                         std::vector<std::pair<uint32_t, uint32_t>> pairs)
    : poses_(poses), pairs_(std::move(pairs)) {
  column_begin_.assign(poses + 1, 0);
  for (const auto& [column, row] : pairs_) ++column_begin_[column + 1];
  for (uint32_t c = 0; c < poses; ++c) column_begin_[c + 1] += column_begin_[c];
  const double all = 0.5 * poses * (poses + 1.0);
  is_dense_ = poses <= kAlwaysDensePoses ||
              (poses <= kMaxDensePoses && static_cast<double>(pairs_.size()) > kDenseShare * all);
  if (is_dense_) {
    dense_.setZero(6 * poses, 6 * poses);
  } else {
    MakePattern();
  }
}

uint32_t ReducedCameraSystem::BlockIndex(uint32_t row, uint32_t column) const {
  const auto begin = pairs_.begin() + column_begin_[column];
  const auto end = pairs_.begin() + column_begin_[column + 1];
  const auto it = std::lower_bound(begin, end, std::pair(column, row));
  return static_cast<uint32_t>(it - pairs_.begin());
}

bool ReducedCameraSystem::Solve(const std::vector<Matrix6d>& blocks,
                                const Eigen::VectorXd& right_side, Eigen::VectorXd& step) {
  if (poses_ == 0) {
    step.resize(0);
    return true;
  }
  return (is_dense_ ? SolveDense(blocks, right_side, step)
                    : SolveSparse(blocks, right_side, step)) &&
         step.allFinite();
}

bool ReducedCameraSystem::SolveDense(const std::vector<Matrix6d>& blocks,
                                     const Eigen::VectorXd& right_side, Eigen::VectorXd& step) {
  dense_.setZero();
  for (size_t i = 0; i < pairs_.size(); ++i) {
    dense_.block<6, 6>(6 * pairs_[i].second, 6 * pairs_[i].first) = blocks[i];
  }
  // The factorisation is in place: dense_ holds the factor afterwards.
  const Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>, Eigen::Lower> cholesky(dense_);
  if (cholesky.info() != Eigen::Success) return false;
  step = cholesky.solve(right_side);
  return true;
}

// Makes the pattern by scalar columns in order, rows ascending: the order in which SolveSparse
// writes the values.
void ReducedCameraSystem::MakePattern() {
  const auto size = static_cast<Eigen::Index>(6 * poses_);
  std::vector<Eigen::Triplet<double>> triplets;
  triplets.reserve(36 * pairs_.size());
  for (const auto& [column, row] : pairs_) {
    for (uint32_t c = 0; c < 6; ++c) {
      for (uint32_t r = row == column ? c : 0; r < 6; ++r) {
        triplets.emplace_back(static_cast<int>(6 * row + r), static_cast<int>(6 * column + c), 0.0);
      }
    }
  }
  sparse_.resize(size, size);
  sparse_.setFromTriplets(triplets.begin(), triplets.end());
  cholesky_ = std::make_unique<SparseCholesky>();
  cholesky_->llt.analyzePattern(sparse_);
}

bool ReducedCameraSystem::SolveSparse(const std::vector<Matrix6d>& blocks,
                                      const Eigen::VectorXd& right_side, Eigen::VectorXd& step) {
  double* value = sparse_.valuePtr();
  for (uint32_t column = 0; column < poses_; ++column) {
    for (int c = 0; c < 6; ++c) {
      for (uint32_t i = column_begin_[column]; i < column_begin_[column + 1]; ++i) {
        for (int r = pairs_[i].second == column ? c : 0; r < 6; ++r) *value++ = blocks[i](r, c);
      }
    }
  }
  cholesky_->llt.factorize(sparse_);
  if (cholesky_->llt.info() != Eigen::Success) return false;
  step = cholesky_->llt.solve(right_side);
  return true;
}

}  // namespace corbslam
