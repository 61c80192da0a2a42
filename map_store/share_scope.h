// What may be news to an agent since it was last told everything.
#ifndef CORBSLAM_MAP_STORE_SHARE_SCOPE_H_
#define CORBSLAM_MAP_STORE_SHARE_SCOPE_H_

#include <set>
#include <vector>

#include "map_store/mission_state.h"

namespace corbslam::map_store {

struct ShareScope {
  // Nothing is known of what the agent was told: all is to be compared, and the rest is empty.
  bool everything = false;
  // Fusion may have moved anything.
  bool places = false;
  // Whose owners, landmarks or foreign observations changed; what of them, local map by local map.
  std::set<LocalMapId> local_maps;
  std::vector<KeyframeId> keyframes;
  std::vector<MapPointId> points;
};

ShareScope FindShareScope(const MissionState& state, const Island& island, const ShareState& share);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_SHARE_SCOPE_H_
