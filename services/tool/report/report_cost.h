// Computes what a run cost for each minute of one robot's pictures.
#ifndef CORBSLAM_SERVICES_TOOL_REPORT_REPORT_COST_H_
#define CORBSLAM_SERVICES_TOOL_REPORT_REPORT_COST_H_

#include <map>
#include <optional>
#include <string>

#include "services/tool/report/report.h"

namespace corbslam::services {

struct RobotMinuteCost {
  double pictures_s = 0;  // Of all robots together, in seconds by their cameras' clocks.
  // Processor seconds, user and system, for a minute of one robot's pictures: those of a robot's
  // own process (nullopt if one of them is not known), and those of each server.
  std::optional<double> robot_cpu_s;
  std::map<std::string, double> servers_cpu_s;
  double global_adjustments = 0;  // Number for the same minute.
};

// Returns nullopt if no robot has pictures that take time.
std::optional<RobotMinuteCost> ComputeRobotMinuteCost(const RunReport& report);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_TOOL_REPORT_REPORT_COST_H_
