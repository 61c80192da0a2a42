// The figures of report.html on company: what each robot holds, and what it gained.
#ifndef CORBSLAM_SERVICES_TOOL_REPORT_HTML_HELD_PLOTS_H_
#define CORBSLAM_SERVICES_TOOL_REPORT_HTML_HELD_PLOTS_H_

#include <string>

#include "services/tool/report/html/report_page.h"

namespace corbslam::services {

// Returns the maps that robots hold from above as the paper's figure 5 draws them, each whole and
// nearer, of the first eight robots; an empty text if none holds anything. All of them together
// show some 24,000 points at most.
std::string HeldPlots(const ReportDetail& detail);
// Returns bars of each robot's absolute error with company and alone; an empty text without errors.
// The report has company.
std::string CompanyPlots(const RunReport& report);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_TOOL_REPORT_HTML_HELD_PLOTS_H_
