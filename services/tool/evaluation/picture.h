// Composes the picture of a fused map.
#ifndef CORBSLAM_SERVICES_TOOL_EVALUATION_PICTURE_H_
#define CORBSLAM_SERVICES_TOOL_EVALUATION_PICTURE_H_

#include <map>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "services/client/store/driven_way.h"
#include "services/client/store/served_mission.h"
#include "services/tool/evaluation/accuracy.h"
#include "slam/rendering/map_picture.h"

namespace corbslam::services {

// Returns the robot that is drawn as own: `wanted`, or the first robot if `wanted` is empty.
// INVALID_ARGUMENT names the robots there are if none has the wanted name.
absl::StatusOr<std::string> ChooseOwn(const std::string& wanted,
                                      const std::vector<std::string>& robots);

// Where robots drove in the map's frame, by their names.
using DrivenPaths = std::map<std::string, DrivenPath>;
DrivenPaths DrivenOf(const std::vector<RobotPaths>& robots);

// Sorts the robots by their names; `own` is the one shown as own. The truth, where there is one, is
// moved into the map's frame. Robots' paths are as driven where that is known. Of others the
// keyframes are joined with their parents, but for gaps (IsGap): of what is left of a session that
// the store has thinned a straight line would run where nobody was.
MapPicture ComposePicture(const ServedMap& map, const std::string& own,
                          const FusedAccuracy& accuracy, const DrivenPaths& driven = {});

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_TOOL_EVALUATION_PICTURE_H_
