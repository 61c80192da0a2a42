// Finds what may have become news to an agent since the last search.
#ifndef CORBSLAM_MAP_STORE_SHARING_SHARE_NEWS_H_
#define CORBSLAM_MAP_STORE_SHARING_SHARE_NEWS_H_

#include <vector>

#include "map_store/state/mission_state.h"
#include "map_store/state/share_state.h"

namespace corbslam::map_store {

// Adds what it finds to `share.news`. Returns the local maps whose owners, landmarks or foreign
// observations changed.
std::vector<LocalMapId> CollectNews(const MissionState& state, const Island& island,
                                    ShareState& share);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_SHARING_SHARE_NEWS_H_
