// Copies what a map store's statistics know of a run.
#ifndef CORBSLAM_SERVICES_TOOL_REPORT_STORE_STATISTICS_H_
#define CORBSLAM_SERVICES_TOOL_REPORT_STORE_STATISTICS_H_

#include "corbslam/v1/resources.pb.h"
#include "services/tool/report/report.h"

namespace corbslam::services {

// Sets what the statistics know: fused, overlaps, merge and adjustment times, transfer.
void AddStatistics(const v1::MissionStatistics& statistics, RunReport& report);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_TOOL_REPORT_STORE_STATISTICS_H_
