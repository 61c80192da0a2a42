// Which of the keyframes that an agent lacks it is sent first.
#ifndef CORBSLAM_MAP_STORE_SHARING_SHARE_ORDER_H_
#define CORBSLAM_MAP_STORE_SHARING_SHARE_ORDER_H_

#include <map>
#include <vector>

#include "map_store/state/mission_state.h"
#include "map_store/state/share_state.h"
#include "map_store/view/placement.h"

namespace corbslam::map_store {

// Of many those that see most of the agent's own landmarks come first, then the nearest; of a few
// the nearest. Landmarks are counted now and then and kept in share.news: it takes a look at the
// agent's whole map.
std::vector<KeyframeId> OrderNewKeyframes(const MissionState& state,
                                          const std::map<KeyframeId, const Keyframe*>& waiting,
                                          PoseCache& poses, ShareState& share);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_SHARING_SHARE_ORDER_H_
