#include "client_agent/tracking/others_shape.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

#include "absl/container/flat_hash_map.h"
#include "slam/optimisation/pose_covariance.h"

namespace corbslam::client_agent {
namespace {

// A frame that sees fewer of a map's points is not led by it.
constexpr int kLeastToLead = 60;
// Two frames that see fewer points in common say nothing of a motion.
constexpr size_t kLeastCommon = 30;
// A step ends when fewer are left in common, or after so many frames: the longer it is, the less
// the noise of one frame matters.
constexpr size_t kManyCommon = 100;
constexpr int kMostFrames = 5;
constexpr size_t kMostSteps = 8;
// What of a map moved by more since the step began was put right meanwhile.
constexpr double kPutRight_m = 0.02;
// Over up to eight steps good maps, and poor ones that are whole, of recorded and simulated drives
// came to 0.61 of what is certain here at most; one that was torn in a curve came to 1.5
// (docs/lab/2026-11-29-others-shape.md). Chi-square has six degrees of freedom, and says little by
// itself: a rig that is not quite calibrated has 177 in a good map.
constexpr double kCertain_chi2 = 80;
constexpr double kLeastTurn_rad = 0.4 * std::numbers::pi / 180;

bool SeesOf(const Association& association, LocalMapId local_map) {
  return association.kind == Association::Kind::kMapPoint && association.id.local_map == local_map;
}

// Returns others' local map of which the frame sees most, if it is enough.
std::optional<LocalMapId> MostSeen(const Frame& frame, LocalMapId own) {
  std::map<LocalMapId, int> seen;
  for (const Association& association : frame.associations) {
    const bool is_others =
        association.kind == Association::Kind::kMapPoint && association.id.local_map != own;
    if (is_others) ++seen[association.id.local_map];
  }
  const auto most = std::ranges::max_element(
      seen, [](const auto& a, const auto& b) { return a.second < b.second; });
  if (most == seen.end() || most->second < kLeastToLead) return std::nullopt;
  return most->first;
}

// What two frames see of a map's points: where the earlier one's own sight has them, in its
// camera's frame, and where the later one sees them.
struct Common {
  std::vector<PoseObservation> observations;
  double moved_m = 0;  // The largest that a point moved in the map meanwhile.
};

Common FindCommon(const Frame& earlier, const Frame& later, LocalMapId local_map) {
  absl::flat_hash_map<MapPointId, size_t> keypoint_of;
  for (size_t i = 0; i < earlier.associations.size(); ++i) {
    const bool is_located = earlier.keypoints()[i].HasDepth();
    if (is_located && SeesOf(earlier.associations[i], local_map)) {
      keypoint_of.emplace(earlier.associations[i].id, i);
    }
  }
  Common common;
  const Camera& camera = earlier.camera();
  for (size_t i = 0; i < later.associations.size(); ++i) {
    const Association& association = later.associations[i];
    if (!SeesOf(association, local_map)) continue;
    const auto found = keypoint_of.find(association.id);
    if (found == keypoint_of.end()) continue;
    const Keypoint& before = earlier.keypoints()[found->second];
    const Keypoint& now = later.keypoints()[i];
    const double depth_m = DepthFromDisparity(camera, before.disparity_px);
    common.observations.push_back(
        {Unproject(camera, before.x_px, before.y_px, depth_m), now.Pixel(), now.disparity_px,
         ScalePyramid::Variance_px2(before.octave) + ScalePyramid::Variance_px2(now.octave)});
    const Eigen::Vector3d& was = earlier.associations[found->second].position_in_map;
    common.moved_m = std::max(common.moved_m, (association.position_in_map - was).norm());
  }
  return common;
}

}  // namespace

std::optional<MapContradiction> OthersShape::Add(const Frame& frame, LocalMapId own) {
  const std::optional<LocalMapId> local_map =
      frame.camera().IsMetric() ? MostSeen(frame, own) : std::nullopt;
  if (!local_map.has_value() || contradicting_.contains(*local_map)) {
    first_.reset();
    steps_.clear();
    return std::nullopt;
  }
  if (!first_.has_value() || local_map_ != *local_map) {
    BeginAnew(frame, *local_map);
    return std::nullopt;
  }
  const Common common = FindCommon(*first_, frame, local_map_);
  if (common.observations.size() < kLeastCommon || common.moved_m > kPutRight_m) {
    BeginAnew(frame, local_map_);
    return std::nullopt;
  }
  if (++frames_ < kMostFrames && common.observations.size() >= kManyCommon) return std::nullopt;
  return EndStep(frame, common.observations);
}

void OthersShape::BeginAnew(const Frame& frame, LocalMapId local_map) {
  local_map_ = local_map;
  steps_.clear();
  first_ = frame;
  frames_ = 0;
}

std::optional<MapContradiction> OthersShape::EndStep(const Frame& frame,
                                                     const std::vector<PoseObservation>& common) {
  const Rigid3d by_map = frame.camera_from_map * first_->camera_from_map.Inverse();
  const PoseEstimate estimate = OptimisePose(frame.camera(), by_map, common);
  std::vector<PoseObservation> inliers;
  for (size_t i = 0; i < common.size(); ++i) {
    if (estimate.is_inlier[i]) inliers.push_back(common[i]);
  }
  const auto covariance = PoseCovariance(frame.camera(), estimate.camera_from_map, inliers);
  if (inliers.size() < kLeastCommon || !covariance.has_value()) {
    BeginAnew(frame, local_map_);
    return std::nullopt;
  }
  steps_.push_back({by_map, estimate.camera_from_map, *covariance});
  if (steps_.size() > kMostSteps) steps_.pop_front();
  first_ = frame;
  frames_ = 0;
  for (size_t steps = 1; steps <= steps_.size(); ++steps) {
    const std::optional<MapBend> bend = Judge(steps);
    if (!bend.has_value()) continue;
    contradicting_.insert(local_map_);
    return MapContradiction{.local_map = local_map_, .bend = bend};
  }
  return std::nullopt;
}

std::optional<MapBend> OthersShape::Judge(size_t steps) const {
  Rigid3d by_map;
  Rigid3d by_sight;
  Matrix6d covariance = Matrix6d::Zero();
  MapBend bend;
  for (auto step = steps_.end() - static_cast<std::ptrdiff_t>(steps); step != steps_.end();
       ++step) {
    const Matrix6d adjoint = AdjointSE3(step->by_sight);
    covariance = adjoint * covariance * adjoint.transpose() + step->covariance;
    by_map = step->by_map * by_map;
    by_sight = step->by_sight * by_sight;
    bend.way_m += step->by_map.translation.norm();
  }
  const Rigid3d difference = by_sight * by_map.Inverse();
  const Vector6d error = LogSE3(difference);
  if (error.dot(covariance.ldlt().solve(error)) < kCertain_chi2) return std::nullopt;
  bend.turn_rad = LogSO3(difference.rotation).norm();
  if (bend.turn_rad < kLeastTurn_rad) return std::nullopt;
  // Where the later camera is, as the earlier one has it, as far off in both.
  const Eigen::Vector3d sight = by_sight.Inverse().translation;
  const Eigen::Vector3d map = by_map.Inverse().translation;
  if (map.norm() > 0) bend.shift_m = (sight - map * (sight.norm() / map.norm())).norm();
  return bend;
}

}  // namespace corbslam::client_agent
