#include "client_agent/source_checks/pair_evidence.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <random>
#include <utility>
#include <vector>

#include "slam/util/median.h"
#include "slam/util/status_macros.h"

namespace corbslam::client_agent {
namespace {

// A corner is found in a pixel of its octave: rows of a match agree within two of them.
constexpr double kRowBand_px = 2.0;
constexpr double kMinDisparity_px = 1.5;
constexpr double kUnmoved_px = 0.5;
constexpr int kTrials = 200;
constexpr int kRefinements = 3;
// Mounting errors are smaller; a larger tilt is another picture.
constexpr double kMaxSlope = 0.1;

struct RowSample {
  Eigen::Vector3d design;  // Factors of RowFit's three numbers.
  double difference_px;
  double scale;
};

std::vector<RowSample> ToSamples(const std::vector<FeatureMatch>& matches, const cv::Size& size) {
  std::vector<RowSample> samples;
  samples.reserve(matches.size());
  for (const FeatureMatch& match : matches) {
    samples.push_back({{1, match.in_a.x() - size.width / 2.0, match.in_a.y() - size.height / 2.0},
                       match.in_b.y() - match.in_a.y(),
                       match.scale});
  }
  return samples;
}

bool Agrees(const RowSample& sample, const Eigen::Vector3d& fit) {
  return std::abs(sample.difference_px - fit.dot(sample.design)) <= kRowBand_px * sample.scale;
}

size_t CountAgreeing(const std::vector<RowSample>& samples, const Eigen::Vector3d& fit) {
  return static_cast<size_t>(std::count_if(samples.begin(), samples.end(),
                                           [&](const RowSample& s) { return Agrees(s, fit); }));
}

double RowScore(const std::vector<RowSample>& samples) {
  double score = 0;
  for (const RowSample& sample : samples) {
    const double share = sample.difference_px / (kRowBand_px * sample.scale);
    score += std::max(0.0, 1 - share * share);
  }
  return score;
}

// Fits least squares to the samples that agree with `fit`, weighted by the precision of their
// octave.
Eigen::Vector3d Refine(const std::vector<RowSample>& samples, Eigen::Vector3d fit) {
  for (int i = 0; i < kRefinements; ++i) {
    Eigen::Matrix3d normal = Eigen::Matrix3d::Identity() * 1e-9;
    Eigen::Vector3d right_side = Eigen::Vector3d::Zero();
    for (const RowSample& sample : samples) {
      if (!Agrees(sample, fit)) continue;
      const double weight = 1 / (sample.scale * sample.scale);
      normal += weight * sample.design * sample.design.transpose();
      right_side += weight * sample.difference_px * sample.design;
    }
    fit = normal.ldlt().solve(right_side);
  }
  return fit;
}

// Returns the fit that most matches agree with (RANSAC on three); rectified rows are the first
// candidate.
Eigen::Vector3d FitRows(const std::vector<RowSample>& samples) {
  Eigen::Vector3d best = Eigen::Vector3d::Zero();
  if (samples.size() < 3) return best;
  size_t most = CountAgreeing(samples, best);
  std::mt19937 random(1);  // A fixed seed: the same sample gives the same finding.
  for (int trial = 0; trial < kTrials; ++trial) {
    Eigen::Matrix3d design;
    Eigen::Vector3d differences;
    for (int i = 0; i < 3; ++i) {
      const RowSample& sample = samples[random() % samples.size()];
      design.row(i) = sample.design.transpose();
      differences(i) = sample.difference_px;
    }
    const Eigen::FullPivLU<Eigen::Matrix3d> lu(design);
    if (!lu.isInvertible()) continue;
    const Eigen::Vector3d fit = lu.solve(differences);
    if (fit.tail<2>().cwiseAbs().maxCoeff() > kMaxSlope) continue;
    const size_t agreeing = CountAgreeing(samples, fit);
    if (agreeing > most) {
      most = agreeing;
      best = fit;
    }
  }
  return Refine(samples, best);
}

void CountDisparity(const FeatureMatch& match, std::vector<double>& positive,
                    PairEvidence& evidence) {
  const double disparity = match.in_a.x() - match.in_b.x();
  if (std::abs(disparity) < kUnmoved_px) ++evidence.unmoved;
  if (disparity > kMinDisparity_px * match.scale) positive.push_back(disparity);
  if (disparity < -kMinDisparity_px * match.scale) ++evidence.negative;
}

// `features` as in PairEvidence; `matches` are those of the two pictures of `size`.
PairEvidence GatherPairEvidence(size_t features, const std::vector<FeatureMatch>& matches,
                                const cv::Size& size) {
  const std::vector<RowSample> samples = ToSamples(matches, size);
  const Eigen::Vector3d fit = FitRows(samples);
  PairEvidence evidence;
  evidence.features = features;
  evidence.matches = matches.size();
  evidence.row_score = RowScore(samples);
  evidence.fit = {fit(0), fit(1), fit(2)};
  std::vector<double> errors;
  std::vector<double> residuals;
  std::vector<double> positive;
  for (size_t i = 0; i < matches.size(); ++i) {
    if (!Agrees(samples[i], fit)) continue;
    errors.push_back(std::abs(fit.dot(samples[i].design)));
    residuals.push_back(std::abs(samples[i].difference_px - fit.dot(samples[i].design)));
    CountDisparity(matches[i], positive, evidence);
  }
  evidence.related = errors.size();
  evidence.positive = positive.size();
  if (!errors.empty()) evidence.row_error_px = Median(std::move(errors));
  if (!residuals.empty()) evidence.residual_px = Median(std::move(residuals));
  if (!positive.empty()) evidence.median_disparity_px = Median(std::move(positive));
  return evidence;
}

// With fewer features nothing tells whether matches are missing or were never to be had.
constexpr size_t kMinFeatures = 100;

bool HasEnough(const CheckFeatures& side) { return side.features.keypoints.size() >= kMinFeatures; }

// Matches with rows farther apart are taken for wrong ones.
constexpr double kMostRows_px = 40;

bool IsFarApart(const FeatureMatch& match) {
  return std::abs(match.in_b.y() - match.in_a.y()) > kMostRows_px;
}

bool HasSize(const cv::Mat& grey, const Camera& camera) {
  return grey.type() == CV_8UC1 && grey.cols == camera.width_px && grey.rows == camera.height_px;
}

}  // namespace

absl::StatusOr<PairPreparation> PairPreparation::Make(const StereoCalibration& calibration) {
  PairPreparation preparation;
  preparation.camera_ = calibration.camera;
  preparation.right_cx_offset_px_ = calibration.right_cx_offset_px;
  if (calibration.raw.has_value()) {
    ASSIGN_OR_RETURN(preparation.rectifier_, StereoRectifier::Make(*calibration.raw));
    preparation.camera_ = preparation.rectifier_->camera();
  }
  return preparation;
}

std::optional<PairPreparation::Pictures> PairPreparation::Rectify(const SensorImages& images,
                                                                  bool exchanged) const {
  const cv::Mat& left = exchanged ? images.right : images.grey;
  const cv::Mat& right = exchanged ? images.grey : images.right;
  if (!HasSize(left, camera_) || !HasSize(right, camera_)) return std::nullopt;
  if (!rectifier_.has_value()) return Pictures{left, right};
  Pictures rectified;
  if (!rectifier_->RectifyLeft(left, rectified.left).ok() ||
      !rectifier_->RectifyRight(right, rectified.right).ok()) {
    return std::nullopt;
  }
  return rectified;
}

std::optional<PairPreparation::Sides> PairPreparation::Extract(const SensorImages& images,
                                                               bool exchanged) const {
  const std::optional<Pictures> pictures = Rectify(images, exchanged);
  if (!pictures.has_value()) return std::nullopt;
  Sides sides{ExtractCheckFeatures(pictures->left), ExtractCheckFeatures(pictures->right)};
  for (Keypoint& keypoint : sides.right.features.keypoints) {
    keypoint.x_px -= static_cast<float>(right_cx_offset_px_);
  }
  return sides;
}

std::optional<std::vector<FeatureMatch>> PairPreparation::Match(
    const std::optional<Sides>& left, const std::optional<Sides>& right) const {
  if (!left.has_value() || !right.has_value()) return std::nullopt;
  if (!HasEnough(left->left) || !HasEnough(right->right)) return std::nullopt;
  return MatchFeatures(left->left, right->right);
}

PairEvidence PairPreparation::Weigh(const Sides& left, const Sides& right,
                                    const std::vector<FeatureMatch>& matches) const {
  return GatherPairEvidence(
      std::min(left.left.features.keypoints.size(), right.right.features.keypoints.size()), matches,
      {camera_.width_px, camera_.height_px});
}

std::optional<PairEvidence> PairPreparation::Compare(const std::optional<Sides>& left,
                                                     const std::optional<Sides>& right) const {
  const auto matches = Match(left, right);
  if (!matches.has_value()) return std::nullopt;
  return Weigh(*left, *right, *matches);
}

std::vector<JudgedPair> PairPreparation::Judge(const Sample& sample, bool exchanged) const {
  std::vector<std::optional<Sides>> sides;
  sides.reserve(sample.size());
  for (const SampleFrame& frame : sample) sides.push_back(Extract(frame.images, exchanged));
  std::vector<JudgedPair> pairs;
  for (size_t i = 0; i < sample.size(); ++i) {
    std::optional<std::vector<FeatureMatch>> matches = Match(sides[i], sides[i]);
    if (!matches.has_value()) continue;
    JudgedPair pair{sample[i].number, Weigh(*sides[i], *sides[i], *matches), {}, {}, {}};
    std::erase_if(*matches, IsFarApart);
    pair.matches = *std::move(matches);
    if (i > 0 && sample[i - 1].number + 1 == sample[i].number) {
      pair.with_before = Compare(sides[i], sides[i - 1]);
    }
    if (i + 1 < sample.size() && sample[i + 1].number == sample[i].number + 1) {
      pair.with_after = Compare(sides[i], sides[i + 1]);
    }
    pairs.push_back(std::move(pair));
  }
  return pairs;
}

double PairPreparation::MatchShareInTime(const Sample& sample) const {
  std::vector<double> shares;
  for (size_t i = 0; i + 1 < sample.size(); ++i) {
    if (sample[i].number + 1 != sample[i + 1].number) continue;
    const std::optional<Sides> now = Extract(sample[i].images, false);
    const std::optional<Sides> next = Extract(sample[i + 1].images, false);
    if (!now.has_value() || !next.has_value() || !HasEnough(now->left)) continue;
    shares.push_back(static_cast<double>(MatchFeatures(now->left, next->left).size()) /
                     static_cast<double>(now->left.features.keypoints.size()));
  }
  return shares.empty() ? 0 : Median(std::move(shares));
}

}  // namespace corbslam::client_agent
