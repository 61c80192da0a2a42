// What a run cost for each minute of one robot's pictures.
#ifndef CORBSLAM_SERVICES_TOOL_REPORT_REPORT_COST_H_
#define CORBSLAM_SERVICES_TOOL_REPORT_REPORT_COST_H_

#include <map>
#include <optional>
#include <string>

#include "services/tool/report/report.h"

namespace corbslam {

struct RobotMinuteCost {
  double pictures_s = 0;  // Of all robots together, by their cameras' clocks.
  // Processor seconds, user and system, a minute of one robot's pictures: of a robot's own process
  // (nullopt where one is not known), and of each server's.
  std::optional<double> robot_cpu_s;
  std::map<std::string, double> servers_cpu_s;
  double global_adjustments = 0;  // In the same minute.
};

// Nothing where no robot has pictures that take time.
std::optional<RobotMinuteCost> ComputeRobotMinuteCost(const RunReport& report);

}  // namespace corbslam

#endif  // CORBSLAM_SERVICES_TOOL_REPORT_REPORT_COST_H_
