// The plots of report.html.
#ifndef CORBSLAM_SERVICES_TOOL_REPORT_HTML_REPORT_PLOTS_H_
#define CORBSLAM_SERVICES_TOOL_REPORT_HTML_REPORT_PLOTS_H_

#include <string>

#include "services/tool/report/html/report_page.h"

namespace corbslam::services {

// Each returns HTML: the figures, or a sentence that says why there are none.
std::string AccuracyPlots(const ReportDetail& detail);
std::string RobotPlots(const RunReport& report, const ReportDetail& detail);
std::string FusionPlots(const RunReport& report);
// The map from above as SVG, with at most 12,000 points; a sentence if there is no map.
std::string FlatMap(const ReportDetail& detail);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_TOOL_REPORT_HTML_REPORT_PLOTS_H_
