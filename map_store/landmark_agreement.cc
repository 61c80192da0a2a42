#include "map_store/landmark_agreement.h"

#include <algorithm>
#include <limits>
#include <map>
#include <vector>

#include "map_store/island_view.h"
#include "map_store/placement.h"

namespace corbslam::map_store {
namespace {

// One keyframe and what it sees where, in the island's frame.
class Sighting {
 public:
  Sighting(const MissionState& state, const Keyframe& keyframe, PoseCache& poses)
      : keyframe_(keyframe) {
    const LocalMapState& local_map = *state.FindLocalMap(keyframe.id().local_map);
    camera_from_island_ = poses.Of(local_map).at(keyframe.id());
    const std::vector<MapPointId> seen = ObservedPoints(state, local_map, keyframe);
    for (uint32_t k = 0; k < seen.size(); ++k) {
      if (seen[k].IsValid()) keypoint_of_[seen[k]] = k;
    }
  }

  const std::map<MapPointId, uint32_t>& keypoint_of() const { return keypoint_of_; }

  double ErrorPx(MapPointId id, const Eigen::Vector3d& position_in_island) const {
    const Eigen::Vector3d x_in_camera = camera_from_island_ * position_in_island;
    if (x_in_camera.z() <= 0) return std::numeric_limits<double>::max();
    const Keypoint& keypoint = keyframe_.keypoints()[keypoint_of_.at(id)];
    return (Project(keyframe_.camera(), x_in_camera) -
            Eigen::Vector2d(keypoint.x_px, keypoint.y_px))
        .norm();
  }

 private:
  const Keyframe& keyframe_;
  Similarity3d camera_from_island_;
  std::map<MapPointId, uint32_t> keypoint_of_;
};

}  // namespace

std::optional<double> LandmarkDisagreementPx(const MissionState& state, KeyframeId a,
                                             KeyframeId b) {
  const Keyframe* first = state.FindKeyframe(a);
  const Keyframe* second = state.FindKeyframe(b);
  if (first == nullptr || second == nullptr) return std::nullopt;
  const Unplaced none;
  PoseCache poses(state.global, none);
  const Sighting by_first(state, *first, poses);
  const Sighting by_second(state, *second, poses);
  std::vector<double> errors_px;
  for (const auto& [id, keypoint] : by_first.keypoint_of()) {
    const MapPoint* point = state.FindPoint(id);
    if (point == nullptr || !by_second.keypoint_of().contains(id)) continue;
    const LocalMapState& owner = *state.FindLocalMap(id.local_map);
    const Eigen::Vector3d position = ComputePosition(*point, owner, state.global, poses.Of(owner));
    errors_px.push_back(std::max(by_first.ErrorPx(id, position), by_second.ErrorPx(id, position)));
  }
  if (errors_px.empty()) return std::nullopt;
  const auto middle = errors_px.begin() + static_cast<std::ptrdiff_t>(errors_px.size() / 2);
  std::nth_element(errors_px.begin(), middle, errors_px.end());
  return *middle;
}

}  // namespace corbslam::map_store
