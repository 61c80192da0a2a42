#include "services/tool/report/report_cost.h"

namespace corbslam::services {
namespace {

constexpr double kMinute_s = 60;

}  // namespace

std::optional<RobotMinuteCost> ComputeRobotMinuteCost(const RunReport& report) {
  RobotMinuteCost cost;
  std::optional<double> robots_cpu_s = 0;
  for (const RobotReport& robot : report.robots) {
    cost.pictures_s += robot.pictures_s;
    if (robots_cpu_s.has_value() && robot.cpu_s.has_value()) {
      *robots_cpu_s += *robot.cpu_s;
    } else {
      robots_cpu_s.reset();
    }
  }
  if (cost.pictures_s <= 0) return std::nullopt;
  const double per_minute = kMinute_s / cost.pictures_s;
  if (robots_cpu_s.has_value()) cost.robot_cpu_s = *robots_cpu_s * per_minute;
  for (const auto& [name, server] : report.servers) {
    cost.servers_cpu_s[name] = server.cpu_s * per_minute;
  }
  cost.global_adjustments = static_cast<double>(report.global_ba_ms.size()) * per_minute;
  return cost;
}

}  // namespace corbslam::services
