#include "client_agent/tracking/others_scale.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>

namespace corbslam::client_agent {
namespace {

// So many of a map's points with disparities are a sample.
constexpr int kEnoughPoints = 30;
// What is off by more is a false match.
constexpr double kMaxError_px = 3;
constexpr size_t kFramesOfABlock = 10;
constexpr size_t kEnoughBlocks = 4;
// Two are enough where both are beyond this: a robot drives by a map that is so wrong no longer
// than it must.
constexpr double kGrossLogScale = 0.015;
// Older ones are of another place, and a mean of many would be certain of next to nothing.
constexpr size_t kMostBlocks = 16;
// A mean is certain where it is beyond so many of its standard deviations. Good maps of recorded
// and simulated drives stayed below 4.4; those with noisy pictures or a wrong rig came beyond 7
// after 40 to 120 frames (docs/lab/2026-11-29-others-distances.md).
constexpr double kCertain = 7;
// What is smaller does not matter, and means of few blocks scatter less by chance.
constexpr double kLeastLogScale = 1.5e-3;
constexpr double kLeastSigmaOfBlock = 5e-4;

// A fit of predicted to measured disparities.
struct Fit {
  double measured_by_predicted = 0;
  double predicted2 = 0;
  int points = 0;

  void Add(double predicted_px, double measured_px, double weight) {
    measured_by_predicted += weight * measured_px * predicted_px;
    predicted2 += weight * predicted_px * predicted_px;
    ++points;
  }
  // A map that is too large has disparities that are too small by the same factor.
  double LogScale() const { return std::log(measured_by_predicted / predicted2); }
};

std::map<LocalMapId, Fit> FitOthers(const Frame& frame, LocalMapId own) {
  std::map<LocalMapId, Fit> fits;
  const Camera& camera = frame.camera();
  for (size_t i = 0; i < frame.associations.size(); ++i) {
    const Association& association = frame.associations[i];
    const bool is_others =
        association.kind == Association::Kind::kMapPoint && association.id.local_map != own;
    const Keypoint& keypoint = frame.keypoints()[i];
    if (!is_others || !keypoint.HasDepth()) continue;
    const double depth = (frame.camera_from_map * association.position_in_map).z();
    if (!(depth > 0)) continue;
    const double predicted_px = camera.fx_px * camera.baseline_m / depth;
    const auto measured_px = static_cast<double>(keypoint.disparity_px);
    if (!(std::abs(measured_px - predicted_px) < kMaxError_px)) continue;
    fits[association.id.local_map].Add(predicted_px, measured_px,
                                       1 / ScalePyramid::Variance_px2(keypoint.octave));
  }
  return fits;
}

double MeanOf(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

// Returns the standard deviation of the values' mean, of two values at least.
double SigmaOfMean(const std::vector<double>& values, double mean) {
  double squares = 0;
  for (const double value : values) squares += (value - mean) * (value - mean);
  const auto count = static_cast<double>(values.size());
  return std::max(std::sqrt(squares / (count - 1)), kLeastSigmaOfBlock) / std::sqrt(count);
}

}  // namespace

std::vector<ScaleContradiction> OthersScale::Add(const Frame& frame, LocalMapId own) {
  std::vector<ScaleContradiction> found;
  if (!frame.camera().IsMetric()) return found;
  for (const auto& [local_map, fit] : FitOthers(frame, own)) {
    if (fit.points < kEnoughPoints || contradicting_.contains(local_map)) continue;
    Evidence& evidence = evidence_[local_map];
    evidence.block.push_back(fit.LogScale());
    if (evidence.block.size() < kFramesOfABlock) continue;
    const std::optional<ScaleContradiction> contradiction = Judge(local_map, evidence);
    if (!contradiction.has_value()) continue;
    contradicting_.insert(local_map);
    evidence_.erase(local_map);
    found.push_back(*contradiction);
  }
  return found;
}

namespace {

bool AreGross(const std::vector<double>& means) {
  return means.size() == 2 && std::ranges::all_of(means, [&](double mean) {
           return std::abs(mean) > kGrossLogScale && mean * means.front() > 0;
         });
}

}  // namespace

std::optional<ScaleContradiction> OthersScale::Judge(LocalMapId local_map, Evidence& evidence) {
  evidence.means.push_back(MeanOf(evidence.block));
  evidence.block.clear();
  if (evidence.means.size() > kMostBlocks) evidence.means.erase(evidence.means.begin());
  const bool are_gross = AreGross(evidence.means);
  if (evidence.means.size() < kEnoughBlocks && !are_gross) return std::nullopt;
  const double mean = MeanOf(evidence.means);
  const double sigma = SigmaOfMean(evidence.means, mean);
  const bool is_certain =
      are_gross || (std::abs(mean) > kLeastLogScale && std::abs(mean) > kCertain * sigma);
  if (!is_certain) return std::nullopt;
  return ScaleContradiction{local_map, std::exp(mean), std::exp(mean) * sigma};
}

}  // namespace corbslam::client_agent
