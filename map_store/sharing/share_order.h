// Says in which order an agent is sent the keyframes that it lacks.
#ifndef CORBSLAM_MAP_STORE_SHARING_SHARE_ORDER_H_
#define CORBSLAM_MAP_STORE_SHARING_SHARE_ORDER_H_

#include <cstdint>
#include <set>
#include <vector>

#include "absl/container/btree_map.h"
#include "absl/container/flat_hash_set.h"
#include "map_store/state/mission_state.h"
#include "map_store/state/share_state.h"
#include "map_store/view/placement.h"

namespace corbslam::map_store {

// Counts, now and then, how many of the agent's own landmarks each of many waiting keyframes sees,
// and keeps that in `share.news`. It goes through the agent's whole map, one keyframe at a time.
// Not thread-safe.
class OwnLandmarkCount {
 public:
  // None of the arguments is copied.
  OwnLandmarkCount(const MissionState& state, const std::set<KeyframeId>& waiting,
                   ShareState& share);

  // Looks at one more keyframe. Returns false if all are counted, or need not be. Items may come
  // and go between two calls.
  bool Next();

 private:
  enum class Stage { kOwn, kWaiting, kDone };

  const MissionState& state_;
  const std::set<KeyframeId>& waiting_;
  ShareState& share_;
  const uint64_t revision_;
  Stage stage_ = Stage::kDone;
  KeyframeId next_;
  absl::flat_hash_set<MapPointId> own_landmarks_;
  absl::btree_map<KeyframeId, int> counts_;
};

// Orders the waiting keyframes. If they are many, those that see most of the agent's own landmarks
// come first, then the nearest to any own keyframe, where what lies behind the robot counts as up
// to twice as far away as it is; if they are few, the nearest come first.
std::vector<KeyframeId> OrderNewKeyframes(const MissionState& state,
                                          const std::set<KeyframeId>& waiting, PoseCache& poses,
                                          const ShareState& share);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_SHARING_SHARE_ORDER_H_
