// Finds what may be news to an agent since it was last looked for.
#ifndef CORBSLAM_MAP_STORE_SHARING_SHARE_NEWS_H_
#define CORBSLAM_MAP_STORE_SHARING_SHARE_NEWS_H_

#include <vector>

#include "map_store/state/mission_state.h"
#include "map_store/state/share_state.h"

namespace corbslam::map_store {

// Adds to share.news. Returns the local maps whose owners, landmarks or foreign observations
// changed.
std::vector<LocalMapId> CollectNews(const MissionState& state, const Island& island,
                                    ShareState& share);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_SHARING_SHARE_NEWS_H_
