#include "map_store/sharing/share_order.h"

#include <algorithm>
#include <limits>
#include <tuple>

#include "absl/container/flat_hash_set.h"
#include "map_store/view/sights.h"

namespace corbslam::map_store {
namespace {

using Waiting = std::map<KeyframeId, const Keyframe*>;

// As many may come uncounted before all are counted again.
constexpr size_t kFew = 8;

void CountOwnLandmarks(const MissionState& state, const Waiting& waiting, ShareState& share) {
  absl::flat_hash_set<MapPointId> own_landmarks;
  const LocalMapState& own = *state.FindLocalMap(share.local_map);
  for (const auto& [id, keyframe] : own.map.keyframes()) {
    for (const auto& [keypoint, point] : SightsOf(state, own, keyframe)) {
      own_landmarks.insert(point);
    }
  }
  share.news.own_landmarks.clear();
  for (const auto& [id, keyframe] : waiting) {
    int& count = share.news.own_landmarks[id];
    for (const auto& sight : SightsOf(state, *state.FindLocalMap(id.local_map), *keyframe)) {
      if (own_landmarks.contains(sight.second)) ++count;
    }
  }
  share.news.counted_at_revision = state.global.revision;
}

bool AreCounted(const MissionState& state, const Waiting& waiting, const ShareNews& news) {
  if (news.counted_at_revision != state.global.revision) return false;
  const auto uncounted = std::ranges::count_if(
      waiting, [&news](const auto& item) { return !news.own_landmarks.contains(item.first); });
  return static_cast<size_t>(uncounted) <= kFew;
}

std::vector<Eigen::Vector3d> CentresOf(const IslandPoses& poses) {
  std::vector<Eigen::Vector3d> centres;
  for (const auto& [id, pose] : poses) centres.push_back(CameraCentre(pose.ToRigid()));
  return centres;
}

double SquaredDistance(const Eigen::Vector3d& centre, const std::vector<Eigen::Vector3d>& others) {
  double least = std::numeric_limits<double>::max();
  for (const Eigen::Vector3d& other : others) {
    least = std::min(least, (other - centre).squaredNorm());
  }
  return least;
}

}  // namespace

std::vector<KeyframeId> OrderNewKeyframes(const MissionState& state, const Waiting& waiting,
                                          PoseCache& poses, ShareState& share) {
  const bool many = waiting.size() > kFew;
  if (many && !AreCounted(state, waiting, share.news)) CountOwnLandmarks(state, waiting, share);
  const auto own_landmarks = [many, &share](KeyframeId id) {
    const auto it = share.news.own_landmarks.find(id);
    return many && it != share.news.own_landmarks.end() ? it->second : 0;
  };
  const std::vector<Eigen::Vector3d> own =
      CentresOf(poses.Of(*state.FindLocalMap(share.local_map)));
  std::vector<std::tuple<int, double, KeyframeId>> ranked;
  for (const auto& [id, keyframe] : waiting) {
    const Similarity3d& pose = poses.Of(*state.FindLocalMap(id.local_map)).at(id);
    ranked.emplace_back(-own_landmarks(id), SquaredDistance(CameraCentre(pose.ToRigid()), own), id);
  }
  std::sort(ranked.begin(), ranked.end());
  std::vector<KeyframeId> ids;
  for (const auto& [landmarks, distance, id] : ranked) ids.push_back(id);
  return ids;
}

}  // namespace corbslam::map_store
