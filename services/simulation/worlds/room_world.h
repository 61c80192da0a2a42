// Makes one furnished room around a path, as a flight in a hall is.
#ifndef CORBSLAM_SERVICES_SIMULATION_WORLDS_ROOM_WORLD_H_
#define CORBSLAM_SERVICES_SIMULATION_WORLDS_ROOM_WORLD_H_

#include <cstdint>
#include <vector>

#include "services/simulation/scene.h"
#include "slam/geometry/rigid3.h"

namespace corbslam {

// The room is a box, its walls kRoomMarginM beyond the path, its floor kRoomMarginM below the
// path's lowest point. Furniture stands where no pose comes nearer than kRoomClearanceM. The frame
// is that of scene.h. Pure; there is at least one pose.
Scene BuildRoomScene(const std::vector<Rigid3d>& world_from_camera, uint64_t seed);
constexpr double kRoomMarginM = 1.0;
constexpr double kRoomClearanceM = 0.4;

}  // namespace corbslam

#endif  // CORBSLAM_SERVICES_SIMULATION_WORLDS_ROOM_WORLD_H_
