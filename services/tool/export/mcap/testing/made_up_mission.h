// Makes up missions to record.
#ifndef CORBSLAM_SERVICES_TOOL_EXPORT_MCAP_TESTING_MADE_UP_MISSION_H_
#define CORBSLAM_SERVICES_TOOL_EXPORT_MCAP_TESTING_MADE_UP_MISSION_H_

#include <string>
#include <vector>

#include "absl/status/status.h"
#include "services/client/store/told_map.h"
#include "services/tool/export/mcap/mission_recording.h"

namespace corbslam::testing {

// Local maps of alpha and of a robot whose name is no name.
inline constexpr LocalMapId kAlphas{0xa1};
inline constexpr LocalMapId kHostiles{0xb2};
// Quotes, a slash, a line's end and bytes that are no UTF-8.
inline constexpr char kHostileName[] = "b\"/\n\xff\xc3%";

struct MadeUpMission {
  services::RecordedMission mission;
  // Two islands, which are one at the last revision, 5.
  std::vector<services::ToldMap> moments;
  std::vector<services::RecordedTrajectory> trajectories;
};

// Returns two robots' mission, with everything that a recording holds.
MadeUpMission MakeUpMission();

absl::Status Record(const MadeUpMission& made_up, const std::string& path);

}  // namespace corbslam::testing

#endif  // CORBSLAM_SERVICES_TOOL_EXPORT_MCAP_TESTING_MADE_UP_MISSION_H_
