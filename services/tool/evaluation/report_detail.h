// Puts together what the pictures of report.html show.
#ifndef CORBSLAM_SERVICES_TOOL_EVALUATION_REPORT_DETAIL_H_
#define CORBSLAM_SERVICES_TOOL_EVALUATION_REPORT_DETAIL_H_

#include <optional>
#include <string>
#include <vector>

#include "client_agent/map/near_map.h"
#include "services/client/store/served_mission.h"
#include "services/tool/evaluation/accuracy.h"
#include "services/tool/report/html/report_page.h"

namespace corbslam::services {

// Robots in the order of `robots`, which is that of the accuracy, too.
ReportDetail ComposeDetail(const std::vector<RobotPaths>& robots, const ServedMap& map,
                           const std::string& own, const Accuracy& accuracy);

// Returns the pictures of those robots that hold keyframes; `held` in the order of `robots`.
std::vector<ReportDetail::Held> ComposeHeld(
    const std::vector<RobotPaths>& robots,
    const std::vector<std::optional<client_agent::NearMap>>& held, const ServedMap& map);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_TOOL_EVALUATION_REPORT_DETAIL_H_
