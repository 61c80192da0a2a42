#include "client_agent/tracking/relocalisation.h"

#include <algorithm>
#include <cstddef>
#include <utility>

#include "client_agent/tracking/frame_matching.h"
#include "client_agent/tracking/local_map_view.h"
#include "slam/solvers/pnp_ransac.h"

namespace corbslam::client_agent {
namespace {

constexpr size_t kMaxCandidates = 5;
constexpr int kMinWordMatches = 15;
constexpr int kMinInliers = 50;
// The first guided search is wide, the second fine.
constexpr double kWidenings[] = {5, 2};
// Keyframes farther away, or turned away by more than 60 degrees, see little of what a pose does.
constexpr double kMaxViewDistance_m = 20;
constexpr double kMinViewCosine = 0.5;
// A view turned by 90 degrees counts as one from so much farther away.
constexpr double kMetresOfTurnedView = 10;
constexpr size_t kMaxNearestViews = 3;

std::vector<PoseObservation> Observe(const Frame& frame) {
  std::vector<PoseObservation> observations;
  for (size_t i = 0; i < frame.associations.size(); ++i) {
    if (frame.associations[i].kind == Association::Kind::kNone) continue;
    const Keypoint& keypoint = frame.keypoints()[i];
    observations.push_back({frame.associations[i].position_in_map, keypoint.Pixel(),
                            keypoint.disparity_px, ScalePyramid::Variance_px2(keypoint.octave)});
  }
  return observations;
}

// Searches around the frame's pose, beginning with what the candidate sees.
bool SearchAround(const GuardedMap& guarded, KeyframeId candidate, Frame& frame) {
  for (const double widening : kWidenings) {
    const LocalMapView local = guarded.Read([&](const Map& map) {
      return GatherLocalMap(map, guarded.local_map(), SeenPoints(frame), candidate, frame.camera(),
                            frame.camera_from_map);
    });
    std::vector<MapPointId> visible;
    MatchLocalPoints(local.points, widening, frame, visible);
    const InlierCount inliers =
        OptimiseFramePose(frame.camera_from_map, guarded.local_map(), frame);
    if (inliers.map_points >= kMinInliers) return true;
  }
  return false;
}

bool TryCandidate(const GuardedMap& guarded, KeyframeId candidate, uint64_t seed, Frame& frame) {
  const int matches = guarded.Read([&](const Map& map) {
    const Keyframe* keyframe = map.FindKeyframe(candidate);
    return keyframe == nullptr ? 0 : MatchKeyframe(map, *keyframe, frame);
  });
  if (matches < kMinWordMatches) return false;
  const absl::StatusOr<PoseEstimate> estimate =
      EstimatePose(frame.camera(), Observe(frame), {.seed = seed});
  if (!estimate.ok()) return false;
  frame.camera_from_map = estimate->camera_from_map;
  OptimiseFramePose(frame.camera_from_map, guarded.local_map(), frame);
  return SearchAround(guarded, candidate, frame);
}

// Returns the keyframes whose view is most like that from the pose, the best first.
std::vector<KeyframeId> FindNearestViews(const Map& map, const Rigid3d& camera_from_map) {
  const Eigen::Vector3d centre = CameraCentre(camera_from_map);
  const Eigen::Vector3d axis = camera_from_map.rotation.conjugate() * Eigen::Vector3d::UnitZ();
  std::vector<std::pair<double, KeyframeId>> ranked;
  for (const auto& [id, keyframe] : map.keyframes()) {
    const Eigen::Vector3d other_axis =
        keyframe.camera_from_map.rotation.conjugate() * Eigen::Vector3d::UnitZ();
    const double distance_m = (CameraCentre(keyframe.camera_from_map) - centre).norm();
    const double cosine = axis.dot(other_axis);
    if (distance_m > kMaxViewDistance_m || cosine < kMinViewCosine) continue;
    ranked.emplace_back(distance_m + kMetresOfTurnedView * (1 - cosine), id);
  }
  const size_t count = std::min(ranked.size(), kMaxNearestViews);
  std::partial_sort(ranked.begin(), ranked.begin() + static_cast<std::ptrdiff_t>(count),
                    ranked.end());
  std::vector<KeyframeId> nearest;
  for (size_t i = 0; i < count; ++i) nearest.push_back(ranked[i].second);
  return nearest;
}

}  // namespace

bool RelocaliseFrame(const GuardedMap& map, const PlaceFinder& places, uint64_t seed,
                     Frame& frame) {
  const std::vector<KeyframeId> candidates = places(*frame.words);
  for (size_t i = 0; i < std::min(candidates.size(), kMaxCandidates); ++i) {
    if (TryCandidate(map, candidates[i], seed + i, frame)) return true;
  }
  return false;
}

bool RelocaliseNear(const GuardedMap& map, const Rigid3d& camera_from_map, Frame& frame) {
  const std::vector<KeyframeId> candidates =
      map.Read([&](const Map& now) { return FindNearestViews(now, camera_from_map); });
  for (const KeyframeId candidate : candidates) {
    frame.associations.assign(frame.keypoints().size(), Association());
    frame.camera_from_map = camera_from_map;
    if (SearchAround(map, candidate, frame)) return true;
  }
  return false;
}

}  // namespace corbslam::client_agent
