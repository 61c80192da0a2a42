// Writes report.html: a run's report as one page that needs nothing but itself.
#ifndef CORBSLAM_SERVICES_TOOL_REPORT_HTML_REPORT_PAGE_H_
#define CORBSLAM_SERVICES_TOOL_REPORT_HTML_REPORT_PAGE_H_

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "services/tool/report/html/viewer_frame.h"
#include "services/tool/report/report.h"
#include "slam/evaluation/trajectory_error.h"
#include "slam/rendering/map_picture.h"

namespace corbslam::services {

// What the report's numbers do not hold, and pictures need.
struct ReportDetail {
  struct Tracked {  // A stretch without a lost frame, seconds since begin_ns.
    double begin_s = 0;
    double end_s = 0;
  };
  struct Robot {
    std::string name;
    int64_t begin_ns = 0;  // Time of its first tracked frame.
    std::vector<PoseError> errors;
    bool errors_are_global = false;  // Under the one alignment of all robots, not its own.
    std::vector<LengthError> by_length;
    std::vector<Tracked> tracked;
    std::vector<double> local_maps_s;  // When each further local map begins.
  };
  // What one robot held of the map in the end, in its local map's frame.
  struct Held {
    std::string robot;
    MapPicture map;
    std::optional<MapPicture> nearer;  // Where it drives among others' keyframes.
  };
  std::vector<Robot> robots;  // In the report's order.
  std::vector<Held> held;     // Of those that hold anything.
  MapPicture map;             // The map in the global frame.
  ShownMission recorded;      // What the viewer's page shows.
};

// Every text of the report is escaped. The page forbids itself all but its own styles and script,
// which it names by their hashes; it loads nothing. It shows the map in the viewer's page; without
// that, or where nothing was recorded, as a picture from above.
std::string ToHtml(const RunReport& report, const ReportDetail& detail,
                   const ViewerPage& viewer = {});

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_TOOL_REPORT_HTML_REPORT_PAGE_H_
