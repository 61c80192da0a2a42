// Makes tables and lines for people of what a report says; report.md and report.html show the same.
#ifndef CORBSLAM_SERVICES_TOOL_REPORT_REPORT_TABLES_H_
#define CORBSLAM_SERVICES_TOOL_REPORT_REPORT_TABLES_H_

#include <optional>
#include <string>
#include <vector>

#include "services/tool/report/report.h"

namespace corbslam::services {

struct ReportTable {
  std::vector<std::string> columns;
  std::vector<std::vector<std::string>> rows;  // The first cell says what a row is about.
};

ReportTable RobotTable(const RunReport& report);
ReportTable FusedTable(const RunReport& report);
ReportTable TransferTable(const RunReport& report);
// Without rows if no server is known.
ReportTable ServerTable(const RunReport& report);
// Lines on overlaps, merges and adjustments.
std::vector<std::string> FusionLines(const RunReport& report);
// Returns an empty text if no time is known.
std::string CostLine(const RunReport& report);

// Returns "-" where there is no value.
std::string FormatOr(const std::optional<double>& value, int decimals);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_TOOL_REPORT_REPORT_TABLES_H_
