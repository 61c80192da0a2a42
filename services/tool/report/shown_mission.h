// A mission as a run left it in the store, for the page of its report.
#ifndef CORBSLAM_SERVICES_TOOL_REPORT_SHOWN_MISSION_H_
#define CORBSLAM_SERVICES_TOOL_REPORT_SHOWN_MISSION_H_

#include <string>
#include <vector>

namespace corbslam::services {

// Each text is a serialised message.
struct ShownMission {
  std::string mission;
  // v1.WatchMapResponse, oldest first: all of them together are the map. Empty: nothing was
  // recorded.
  std::vector<std::string> map;
  bool has_points = false;            // Map points are in them.
  bool has_past = false;              // They tell several moments, as ReplayMap does.
  std::string pulse;                  // v1.MissionPulse.
  std::vector<std::string> overlaps;  // v1.Overlap.
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_TOOL_REPORT_SHOWN_MISSION_H_
