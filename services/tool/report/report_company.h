// Says what company gave: what the robots measured that were told what others made, beside what the
// same robots measured alone.
#ifndef CORBSLAM_SERVICES_TOOL_REPORT_REPORT_COMPANY_H_
#define CORBSLAM_SERVICES_TOOL_REPORT_REPORT_COMPANY_H_

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "services/tool/report/report.h"
#include "services/tool/report/report_tables.h"

namespace corbslam::services {

// Returns null if the robots did not play alone, too.
nlohmann::ordered_json CompanyToJson(const RunReport& report);

// The rest is for reports with company.

// A row for each robot, and one for all of them fused.
ReportTable CompanyTable(const RunReport& report);
// Sentences: what each robot gained in accuracy or did not, and how far to trust that.
std::vector<std::string> CompanyLines(const RunReport& report);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_TOOL_REPORT_REPORT_COMPANY_H_
