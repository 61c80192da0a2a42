// The plots of report.html.
#ifndef CORBSLAM_SERVICES_TOOL_REPORT_HTML_REPORT_PLOTS_H_
#define CORBSLAM_SERVICES_TOOL_REPORT_HTML_REPORT_PLOTS_H_

#include <cstddef>
#include <string>

#include "services/tool/report/html/report_page.h"
#include "slam/rendering/map_picture.h"

namespace corbslam::services {

// Each returns HTML: the figures, or a sentence that says why there are none.
std::string AccuracyPlots(const ReportDetail& detail);
std::string RobotPlots(const RunReport& report, const ReportDetail& detail);
std::string FusionPlots(const RunReport& report);
// The map from above as SVG, with at most so many points; a sentence if there is no map.
inline constexpr size_t kMostFlatPoints = 12'000;
std::string FlatMap(const MapPicture& map, size_t most_points = kMostFlatPoints,
                    int width_px = 900);
// A figure element around a plot, with its caption; `note` may be empty.
std::string Figure(const std::string& caption, const std::string& note, const std::string& svg);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_TOOL_REPORT_HTML_REPORT_PLOTS_H_
