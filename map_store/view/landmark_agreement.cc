#include "map_store/view/landmark_agreement.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "absl/container/flat_hash_map.h"
#include "map_store/view/island_view.h"
#include "map_store/view/placement.h"
#include "slam/util/median.h"

namespace corbslam::map_store {
namespace {

double ErrorPx(const Keyframe& keyframe, const Similarity3d& camera_from_island, uint32_t index,
               const Eigen::Vector3d& position_in_island) {
  const Eigen::Vector3d x_in_camera = camera_from_island * position_in_island;
  if (x_in_camera.z() <= 0) return std::numeric_limits<double>::max();
  return (Project(keyframe.camera(), x_in_camera) - keyframe.keypoints()[index].Pixel()).norm();
}

}  // namespace

std::vector<SharedLandmark> FindSharedLandmarks(const MissionState& state, KeyframeId a,
                                                KeyframeId b) {
  const Keyframe* first = state.FindKeyframe(a);
  const Keyframe* second = state.FindKeyframe(b);
  if (first == nullptr || second == nullptr) return {};
  if (state.global.island_of.at(a.local_map) != state.global.island_of.at(b.local_map)) return {};
  const auto by_first = ObservedPoints(state, *state.FindLocalMap(a.local_map), *first);
  const auto by_second = ObservedPoints(state, *state.FindLocalMap(b.local_map), *second);
  absl::flat_hash_map<MapPointId, uint32_t> keypoint_of_first;
  keypoint_of_first.reserve(by_first.size());
  for (uint32_t k = 0; k < by_first.size(); ++k) {
    if (by_first[k].IsValid()) keypoint_of_first[by_first[k]] = k;
  }
  std::vector<SharedLandmark> shared;
  for (uint32_t k = 0; k < by_second.size(); ++k) {
    if (!by_second[k].IsValid()) continue;
    const auto it = keypoint_of_first.find(by_second[k]);
    if (it != keypoint_of_first.end()) shared.push_back({it->first, it->second, k});
  }
  return shared;
}

double LandmarkDisagreementPx(const MissionState& state, KeyframeId a, KeyframeId b,
                              const std::vector<SharedLandmark>& shared) {
  const Unplaced none;
  PoseCache poses(state, none);
  const Similarity3d a_from_island = poses.Of(*state.FindLocalMap(a.local_map)).at(a);
  const Similarity3d b_from_island = poses.Of(*state.FindLocalMap(b.local_map)).at(b);
  std::vector<double> errors_px;
  errors_px.reserve(shared.size());
  for (const SharedLandmark& landmark : shared) {
    const LocalMapState& owner = *state.FindLocalMap(landmark.id.local_map);
    const Eigen::Vector3d position =
        ComputePosition(*owner.map.FindPoint(landmark.id), owner, state.global, poses.Of(owner));
    errors_px.push_back(
        std::max(ErrorPx(*state.FindKeyframe(a), a_from_island, landmark.keypoint_of_a, position),
                 ErrorPx(*state.FindKeyframe(b), b_from_island, landmark.keypoint_of_b, position)));
  }
  return Median(std::move(errors_px));
}

}  // namespace corbslam::map_store
