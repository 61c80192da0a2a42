// Composes the picture of a fused map.
#ifndef CORBSLAM_SERVICES_TOOL_EVALUATION_PICTURE_H_
#define CORBSLAM_SERVICES_TOOL_EVALUATION_PICTURE_H_

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "services/client/store/served_mission.h"
#include "services/tool/evaluation/accuracy.h"
#include "slam/rendering/map_picture.h"

namespace corbslam::services {

// Returns the robot that is drawn as own: `wanted`, or the first robot if `wanted` is empty.
// INVALID_ARGUMENT names the robots there are if none has the wanted name.
absl::StatusOr<std::string> ChooseOwn(const std::string& wanted,
                                      const std::vector<std::string>& robots);

// Sorts the robots by their names; `own` is the one shown as own. The truth, where there is one, is
// moved into the map's frame.
MapPicture ComposePicture(const ServedMap& map, const std::string& own,
                          const FusedAccuracy& accuracy);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_TOOL_EVALUATION_PICTURE_H_
