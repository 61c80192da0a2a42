#include "slam/exchange/overlap.h"

#include <Eigen/Eigenvalues>

namespace corbslam {

bool IsCovariance(const Matrix7d& matrix) {
  // Adding up and turning the axes rounds away so much of the largest entry.
  constexpr double kRounding = 1e-9;
  if (!matrix.allFinite()) return false;
  const double tolerance = kRounding * matrix.cwiseAbs().maxCoeff();
  if ((matrix - matrix.transpose()).cwiseAbs().maxCoeff() > tolerance) return false;
  const Eigen::SelfAdjointEigenSolver<Matrix7d> solver(matrix, Eigen::EigenvaluesOnly);
  return solver.info() == Eigen::Success && solver.eigenvalues()[0] >= -tolerance;
}

std::string ToString(OverlapVerdict verdict) {
  switch (verdict) {
    case OverlapVerdict::kAccepted:
      return "ACCEPTED";
    case OverlapVerdict::kTooFewWordMatches:
      return "TOO_FEW_WORD_MATCHES";
    case OverlapVerdict::kTooFewRansacInliers:
      return "TOO_FEW_RANSAC_INLIERS";
    case OverlapVerdict::kTooFewRefinedInliers:
      return "TOO_FEW_REFINED_INLIERS";
    case OverlapVerdict::kTooFewProjectedMatches:
      return "TOO_FEW_PROJECTED_MATCHES";
    case OverlapVerdict::kNoSecondKeyframe:
      return "NO_SECOND_KEYFRAME";
    case OverlapVerdict::kWrongScale:
      return "WRONG_SCALE";
    case OverlapVerdict::kBendsGraph:
      return "BENDS_GRAPH";
    case OverlapVerdict::kTakenBack:
      return "TAKEN_BACK";
  }
  return "UNKNOWN";
}

}  // namespace corbslam
