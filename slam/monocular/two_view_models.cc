#include "slam/monocular/two_view_models.h"

#include <Eigen/Dense>
#include <array>
#include <cmath>
#include <opencv2/calib3d.hpp>

namespace corbslam {
namespace {

constexpr double kBoundOfTwo = 5.99;
constexpr double kBoundOfOne = 3.84;
// A homography of which all singular values are this near to each other is a rotation.
constexpr double kRotationSpread = 1e-6;

// Moves points so that their centroid is 0 and their mean distance from it along each axis 1.
struct Conditioning {
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();
  Eigen::Vector2d scale = Eigen::Vector2d::Ones();

  Eigen::Vector2d operator()(const Eigen::Vector2d& x) const {
    return (x - centre).cwiseProduct(scale);
  }
  Eigen::Matrix3d Matrix() const {
    Eigen::Matrix3d matrix = Eigen::Matrix3d::Identity();
    matrix(0, 0) = scale.x();
    matrix(1, 1) = scale.y();
    matrix(0, 2) = -scale.x() * centre.x();
    matrix(1, 2) = -scale.y() * centre.y();
    return matrix;
  }
};

template <typename XOf>
std::optional<Conditioning> ConditioningOf(absl::Span<const NormalisedMatch> matches, XOf x_of) {
  const double count = static_cast<double>(matches.size());
  Conditioning conditioning;
  for (const NormalisedMatch& match : matches) conditioning.centre += x_of(match) / count;
  Eigen::Vector2d distance = Eigen::Vector2d::Zero();
  for (const NormalisedMatch& match : matches) {
    distance += (x_of(match) - conditioning.centre).cwiseAbs() / count;
  }
  if (!(distance.minCoeff() > 1e-9)) return std::nullopt;
  conditioning.scale = distance.cwiseInverse();
  return conditioning;
}

struct Conditionings {
  Conditioning of_1;
  Conditioning of_2;
};

std::optional<Conditionings> ConditionBoth(absl::Span<const NormalisedMatch> matches) {
  const auto of_1 = ConditioningOf(matches, [](const NormalisedMatch& m) { return m.x_1; });
  const auto of_2 = ConditioningOf(matches, [](const NormalisedMatch& m) { return m.x_2; });
  if (!of_1.has_value() || !of_2.has_value()) return std::nullopt;
  return Conditionings{*of_1, *of_2};
}

using Equations = Eigen::Matrix<double, Eigen::Dynamic, 9>;

// Returns the matrix whose rows, in one vector, the equations make smallest.
Eigen::Matrix3d SmallestOf(const Equations& equations) {
  const Eigen::Matrix<double, 9, 9> squared = equations.transpose() * equations;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 9, 9>> solver(squared);
  const Eigen::Matrix<double, 9, 1> smallest = solver.eigenvectors().col(0);
  return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(smallest.data());
}

Eigen::Vector3d Homogeneous(const Eigen::Vector2d& x) { return {x.x(), x.y(), 1}; }

// Squared distance of where the homography takes `from` to `to`; infinite at the horizon.
double TransferError2(const Eigen::Matrix3d& H, const Eigen::Vector2d& from,
                      const Eigen::Vector2d& to) {
  const Eigen::Vector3d moved = H * Homogeneous(from);
  return (moved.head<2>() / moved.z() - to).squaredNorm();
}

double LineError2(const Eigen::Vector3d& line, const Eigen::Vector2d& x) {
  const double product = line.dot(Homogeneous(x));
  return product * product / line.head<2>().squaredNorm();
}

// `errors2_of` returns the squared errors in both pictures.
template <typename Errors2Of>
ModelScore Score(absl::Span<const NormalisedMatch> matches, double bound, Errors2Of errors2_of) {
  ModelScore score;
  score.is_inlier.resize(matches.size(), 0);
  for (size_t i = 0; i < matches.size(); ++i) {
    bool is_inlier = true;
    for (const double error2 : errors2_of(matches[i])) {
      const double chi2 = error2 / matches[i].variance;
      // The comparison is written so that NaN is out.
      if (chi2 < bound) {
        score.score += kBoundOfTwo - chi2;
      } else {
        is_inlier = false;
      }
    }
    score.is_inlier[i] = is_inlier ? 1 : 0;
  }
  return score;
}

Eigen::Matrix3d RotationOf(const cv::Mat& matrix) {
  Eigen::Matrix3d rotation;
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 3; ++k) rotation(i, k) = matrix.at<double>(i, k);
  }
  return rotation;
}

bool IsRotation(const Eigen::Matrix3d& H) {
  const Eigen::Vector3d values = Eigen::JacobiSVD<Eigen::Matrix3d>(H).singularValues();
  return values(0) - values(2) < kRotationSpread * values(0);
}

}  // namespace

std::optional<Eigen::Matrix3d> FitHomography(absl::Span<const NormalisedMatch> matches) {
  const std::optional<Conditionings> conditionings = ConditionBoth(matches);
  if (!conditionings.has_value()) return std::nullopt;
  Equations equations(static_cast<Eigen::Index>(2 * matches.size()), 9);
  for (size_t i = 0; i < matches.size(); ++i) {
    const Eigen::Vector2d a = conditionings->of_1(matches[i].x_1);
    const Eigen::Vector2d b = conditionings->of_2(matches[i].x_2);
    const auto row = static_cast<Eigen::Index>(2 * i);
    equations.row(row) << 0, 0, 0, -a.x(), -a.y(), -1, b.y() * a.x(), b.y() * a.y(), b.y();
    equations.row(row + 1) << a.x(), a.y(), 1, 0, 0, 0, -b.x() * a.x(), -b.x() * a.y(), -b.x();
  }
  const Eigen::Matrix3d H =
      conditionings->of_2.Matrix().inverse() * SmallestOf(equations) * conditionings->of_1.Matrix();
  if (!H.allFinite() || !(std::abs(H.determinant()) > 1e-12 * std::pow(H.norm(), 3))) {
    return std::nullopt;
  }
  return H;
}

std::optional<Eigen::Matrix3d> FitEssential(absl::Span<const NormalisedMatch> matches) {
  const std::optional<Conditionings> conditionings = ConditionBoth(matches);
  if (!conditionings.has_value()) return std::nullopt;
  Equations equations(static_cast<Eigen::Index>(matches.size()), 9);
  for (size_t i = 0; i < matches.size(); ++i) {
    const Eigen::Vector2d a = conditionings->of_1(matches[i].x_1);
    const Eigen::Vector2d b = conditionings->of_2(matches[i].x_2);
    equations.row(static_cast<Eigen::Index>(i)) << b.x() * a.x(), b.x() * a.y(), b.x(),
        b.y() * a.x(), b.y() * a.y(), b.y(), a.x(), a.y(), 1;
  }
  const Eigen::Matrix3d fitted = conditionings->of_2.Matrix().transpose() * SmallestOf(equations) *
                                 conditionings->of_1.Matrix();
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(fitted, Eigen::ComputeFullU | Eigen::ComputeFullV);
  if (!fitted.allFinite() || !(svd.singularValues()(1) > 0)) return std::nullopt;
  return svd.matrixU() * Eigen::Vector3d(1, 1, 0).asDiagonal() * svd.matrixV().transpose();
}

ModelScore ScoreHomography(const Eigen::Matrix3d& H, absl::Span<const NormalisedMatch> matches) {
  const Eigen::Matrix3d back = H.inverse();
  return Score(matches, kBoundOfTwo, [&](const NormalisedMatch& match) {
    return std::array{TransferError2(H, match.x_1, match.x_2),
                      TransferError2(back, match.x_2, match.x_1)};
  });
}

ModelScore ScoreEssential(const Eigen::Matrix3d& E, absl::Span<const NormalisedMatch> matches) {
  return Score(matches, kBoundOfOne, [&](const NormalisedMatch& match) {
    return std::array{LineError2(E * Homogeneous(match.x_1), match.x_2),
                      LineError2(E.transpose() * Homogeneous(match.x_2), match.x_1)};
  });
}

std::vector<Rigid3d> MotionsOfHomography(const Eigen::Matrix3d& H) {
  if (IsRotation(H)) return {};
  cv::Mat matrix(3, 3, CV_64F);
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 3; ++k) matrix.at<double>(i, k) = H(i, k);
  }
  std::vector<cv::Mat> rotations;
  std::vector<cv::Mat> translations;
  std::vector<cv::Mat> normals;
  try {
    cv::decomposeHomographyMat(matrix, cv::Mat::eye(3, 3, CV_64F), rotations, translations,
                               normals);
  } catch (const cv::Exception&) {
    return {};
  }
  std::vector<Rigid3d> motions;
  for (size_t i = 0; i < rotations.size(); ++i) {
    const Eigen::Vector3d t(translations[i].at<double>(0), translations[i].at<double>(1),
                            translations[i].at<double>(2));
    const Eigen::Matrix3d R = RotationOf(rotations[i]);
    if (!R.allFinite() || !t.allFinite() || !(t.norm() > 0)) continue;
    motions.push_back({Eigen::Quaterniond(R).normalized(), t.normalized()});
  }
  return motions;
}

std::vector<Rigid3d> MotionsOfEssential(const Eigen::Matrix3d& E) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(E, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Matrix3d W;
  W << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  const Eigen::Vector3d t = svd.matrixU().col(2).normalized();
  std::vector<Rigid3d> motions;
  for (const Eigen::Matrix3d& turn : {W, Eigen::Matrix3d(W.transpose())}) {
    Eigen::Matrix3d R = svd.matrixU() * turn * svd.matrixV().transpose();
    if (R.determinant() < 0) R = -R;
    const Eigen::Quaterniond rotation = Eigen::Quaterniond(R).normalized();
    motions.push_back({rotation, t});
    motions.push_back({rotation, -t});
  }
  return motions;
}

}  // namespace corbslam
