#include "client_agent/tracking/relocalisation.h"

#include <algorithm>

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

std::vector<MapPointId> SeenPoints(const Frame& frame) {
  std::vector<MapPointId> seen;
  for (const Association& association : frame.associations) {
    if (association.id.IsValid()) seen.push_back(association.id);
  }
  return seen;
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
  InlierCount inliers = OptimiseFramePose(frame.camera_from_map, guarded.local_map(), frame);
  for (const double widening : kWidenings) {
    const LocalMapView local = guarded.Read([&](const Map& map) {
      return GatherLocalMap(map, guarded.local_map(), SeenPoints(frame), candidate, frame.camera(),
                            frame.camera_from_map);
    });
    std::vector<MapPointId> visible;
    MatchLocalPoints(local.points, widening, frame, visible);
    inliers = OptimiseFramePose(frame.camera_from_map, guarded.local_map(), frame);
    if (inliers.map_points >= kMinInliers) return true;
  }
  return false;
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

}  // namespace corbslam::client_agent
