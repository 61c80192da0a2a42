// A mission as a run left it in the store, for the page of its report.
#ifndef CORBSLAM_SERVICES_TOOL_REPORT_MISSION_PAST_H_
#define CORBSLAM_SERVICES_TOOL_REPORT_MISSION_PAST_H_

#include <string>
#include <vector>

namespace corbslam::services {

// Each text is a serialised message.
struct MissionPast {
  std::string mission;
  // v1.WatchMapResponse, as ReplayMap tells them; empty: nothing was recorded.
  std::vector<std::string> past;
  std::string pulse;                  // v1.MissionPulse.
  std::vector<std::string> overlaps;  // v1.Overlap.
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_TOOL_REPORT_MISSION_PAST_H_
