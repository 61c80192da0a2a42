// Puts the viewer's page into a report, with the mission that it shows.
#ifndef CORBSLAM_SERVICES_TOOL_REPORT_HTML_VIEWER_FRAME_H_
#define CORBSLAM_SERVICES_TOOL_REPORT_HTML_VIEWER_FRAME_H_

#include <Eigen/Core>
#include <string>
#include <vector>

#include "services/tool/report/shown_mission.h"

namespace corbslam::services {

// The page's own files, as they were built; both empty where it was not.
struct ViewerPage {
  std::string script;
  std::string style;
};
ViewerPage LoadViewerPage(const std::string& folder);

// Returns a frame with the page, which asks nobody for anything: it finds the mission beside its
// script (page/src/feed/recording.ts). `truth` are true paths in the global frame. A policy must
// allow the page's script and style.
std::string ViewerFrame(const ViewerPage& page, const ShownMission& mission,
                        const std::vector<std::vector<Eigen::Vector3d>>& truth);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_TOOL_REPORT_HTML_VIEWER_FRAME_H_
