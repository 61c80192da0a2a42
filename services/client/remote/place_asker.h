// Asks a map store where frames of a robot were taken (MapStore.Localize).
#ifndef CORBSLAM_SERVICES_CLIENT_REMOTE_PLACE_ASKER_H_
#define CORBSLAM_SERVICES_CLIENT_REMOTE_PLACE_ASKER_H_

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "absl/status/statusor.h"
#include "services/client/remote/store_route.h"
#include "slam/geometry/rigid3.h"
#include "slam/map/keyframe.h"

namespace corbslam::services {

// Returns a function that returns the camera's pose in the mission's global frame (x_in_camera =
// camera_from_global * x_in_global), or nullopt where the store does not find the place there. It
// blocks for 2 s at most with each store that it is sent on to. Its errors are the store's.
std::function<absl::StatusOr<std::optional<Rigid3d>>(const KeyframePayload& frame)> MakePlaceAsker(
    std::shared_ptr<StoreRoute> route, const std::string& mission);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_CLIENT_REMOTE_PLACE_ASKER_H_
