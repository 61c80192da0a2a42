#include "client_agent/tracking/others_scale.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

namespace corbslam::client_agent {
namespace {

// So many of a map's points with disparities are a sample.
constexpr size_t kEnoughPoints = 30;
// Of what is further away an error of a tenth of a pixel, as all disparities have it, is per cents.
constexpr double kLeastDisparity_px = 5;
// What is off by more is a false match.
constexpr double kMaxError_px = 3;
constexpr int kFramesOfABlock = 10;
constexpr size_t kEnoughBlocks = 4;
// Two are enough where both are beyond this: a robot drives by a map that is so wrong no longer
// than it must.
constexpr double kGrossLogScale = 0.015;
// What a map is too large by does not change. Where it was only put beside its place when it was
// joined, near points are off by more than far ones, and all by less as the place is put right.
constexpr double kLeastAlike = 2.0 / 3;
// Older ones are of another place, and a mean of many would be certain of next to nothing.
constexpr size_t kMostBlocks = 16;
// A mean is certain where it is beyond so many of its standard deviations, as blocks scatter. Good
// maps of recorded and simulated drives stayed below 6.5; those with noisy pictures or a wrong rig
// came beyond 8 after 40 frames and more (docs/lab/2026-11-29-others-distances.md).
constexpr double kCertain = 8;
// Blocks may see the same points, whose errors stay. So the mean is also beyond so many deviations
// as the points scatter, of which each counts once however often it is seen.
constexpr double kCertainByPoints = 4;
// What is smaller does not matter, and means of few blocks scatter less by chance.
constexpr double kLeastLogScale = 1.5e-3;
constexpr double kLeastSigmaOfBlock = 5e-4;

// Measured and predicted disparities of one frame.
struct Fit {
  double measured2 = 0;
  double measured_by_predicted = 0;
  double predicted2 = 0;
  std::vector<MapPointId> points;

  void Add(MapPointId point, double predicted_px, double measured_px, double weight) {
    measured2 += weight * measured_px * measured_px;
    measured_by_predicted += weight * measured_px * predicted_px;
    predicted2 += weight * predicted_px * predicted_px;
    points.push_back(point);
  }
  // Both are noisy, so that neither is fitted to the other: that factor would be too small. A map
  // that is too large has disparities that are too small by the same factor.
  double Scale() const { return std::sqrt(measured2 / predicted2); }
  // Returns the scale's standard deviation, as the points scatter.
  double Sigma() const {
    const double scale = Scale();
    const double errors2 =
        measured2 - 2 * scale * measured_by_predicted + scale * scale * predicted2;
    return std::sqrt(std::max(errors2, 0.0) / static_cast<double>(points.size()) / predicted2);
  }
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
    const bool is_match = std::abs(measured_px - predicted_px) < kMaxError_px;
    if (!is_match || measured_px + predicted_px < 2 * kLeastDisparity_px) continue;
    fits[association.id.local_map].Add(association.id, predicted_px, measured_px,
                                       1 / ScalePyramid::Variance_px2(keypoint.octave));
  }
  return fits;
}

// Returns the mean of a value of the blocks.
template <typename Block>
double MeanOf(const std::vector<Block>& blocks, double Block::*value) {
  double sum = 0;
  for (const Block& block : blocks) sum += block.*value;
  return sum / static_cast<double>(blocks.size());
}

// Returns the standard deviation of the mean of two blocks at least, as they scatter.
template <typename Block>
double SigmaByBlocks(const std::vector<Block>& blocks, double mean) {
  double squares = 0;
  for (const Block& block : blocks) squares += (block.log_scale - mean) * (block.log_scale - mean);
  const auto count = static_cast<double>(blocks.size());
  return std::max(std::sqrt(squares / (count - 1)), kLeastSigmaOfBlock) / std::sqrt(count);
}

// Returns the same as the points scatter, each of which counts once.
template <typename Block>
double SigmaByPoints(const std::vector<Block>& blocks) {
  absl::flat_hash_set<MapPointId> seen;
  for (const Block& block : blocks) seen.insert(block.seen.begin(), block.seen.end());
  const double of_a_frame = MeanOf(blocks, &Block::points) / static_cast<double>(seen.size());
  return MeanOf(blocks, &Block::sigma) * std::sqrt(of_a_frame);
}

template <typename Block>
bool AreGross(const std::vector<Block>& blocks) {
  if (blocks.size() != 2) return false;
  const double first = blocks[0].log_scale;
  const double second = blocks[1].log_scale;
  const auto [less, more] = std::minmax({std::abs(first), std::abs(second)});
  return first * second > 0 && less > kGrossLogScale && less > kLeastAlike * more;
}

}  // namespace

std::vector<MapContradiction> OthersScale::Add(const Frame& frame, LocalMapId own) {
  std::vector<MapContradiction> found;
  if (!frame.camera().IsMetric()) return found;
  for (const auto& [local_map, fit] : FitOthers(frame, own)) {
    if (fit.points.size() < kEnoughPoints || contradicting_.contains(local_map)) continue;
    Evidence& evidence = evidence_[local_map];
    Block& block = evidence.growing;
    block.log_scale += std::log(fit.Scale()) / kFramesOfABlock;
    block.sigma += fit.Sigma() / kFramesOfABlock;
    block.points += static_cast<double>(fit.points.size()) / kFramesOfABlock;
    block.seen.insert(fit.points.begin(), fit.points.end());
    if (++block.frames < kFramesOfABlock) continue;
    const std::optional<MapContradiction> contradiction = Judge(local_map, evidence);
    if (!contradiction.has_value()) continue;
    contradicting_.insert(local_map);
    evidence_.erase(local_map);
    found.push_back(*contradiction);
  }
  return found;
}

std::optional<MapContradiction> OthersScale::Judge(LocalMapId local_map, Evidence& evidence) {
  std::vector<Block>& blocks = evidence.blocks;
  blocks.push_back(std::exchange(evidence.growing, {}));
  if (blocks.size() > kMostBlocks) blocks.erase(blocks.begin());
  const bool are_gross = AreGross(blocks);
  if (blocks.size() < kEnoughBlocks && !are_gross) return std::nullopt;
  const double mean = MeanOf(blocks, &Block::log_scale);
  const double by_blocks = SigmaByBlocks(blocks, mean);
  const double by_points = SigmaByPoints(blocks);
  if (std::abs(mean) <= kCertainByPoints * by_points) return std::nullopt;
  const bool is_certain =
      are_gross || (std::abs(mean) > kLeastLogScale && std::abs(mean) > kCertain * by_blocks);
  if (!is_certain) return std::nullopt;
  return MapContradiction{local_map, std::exp(mean),
                          std::exp(mean) * std::max(by_blocks, by_points)};
}

}  // namespace corbslam::client_agent
