// Looks a picture's place up in a mission, with the help of a fusion worker.
#ifndef CORBSLAM_MAP_STORE_MISSION_PICTURE_LOCALIZATION_H_
#define CORBSLAM_MAP_STORE_MISSION_PICTURE_LOCALIZATION_H_

#include <functional>

#include "absl/status/statusor.h"
#include "map_store/locating/localize_query.h"
#include "map_store/mission/mission_strand.h"
#include "slam/exchange/fusion_worker.h"

namespace corbslam::map_store {

// Finds the picture's features (or takes them), places that share words with it, and has the worker
// try these, two at a time, until one is right. Changes nothing. Not to find the place is an
// answer: that of the place that got farthest. Errors are the worker's; NOT_FOUND if the mission is
// deleted meanwhile; CANCELLED once `goes_on` says no. Thread-safe.
absl::StatusOr<LocalizeAnswer> LocalizePicture(const MissionStrand& strand, FusionWorker& worker,
                                               const LocalizeQuery& query,
                                               const std::function<bool()>& goes_on);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_MISSION_PICTURE_LOCALIZATION_H_
