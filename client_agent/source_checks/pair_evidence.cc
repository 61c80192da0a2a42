#include "client_agent/source_checks/pair_evidence.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "slam/util/median.h"

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

}  // namespace

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

}  // namespace corbslam::client_agent
