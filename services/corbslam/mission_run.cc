#include "services/corbslam/mission_run.h"

#include <utility>

#include "slam/util/status_macros.h"

namespace corbslam {

absl::Status ReadOutcome(StoreReader& store, const std::vector<RobotPlan>& robots,
                         MissionOutcome& outcome) {
  ASSIGN_OR_RETURN(const v1::GetStatisticsResponse statistics, store.Statistics());
  AddStatistics(statistics.mission(), outcome.report);
  for (const RobotPlan& robot : robots) {
    RobotPaths paths;
    paths.name = robot.name;
    paths.source = robot.source;
    ASSIGN_OR_RETURN(paths.local, store.ReadTrajectory(robot.name, v1::TRAJECTORY_FRAME_LOCAL));
    ASSIGN_OR_RETURN(paths.global, store.ReadTrajectory(robot.name, v1::TRAJECTORY_FRAME_GLOBAL));
    outcome.paths.push_back(std::move(paths));
  }
  ASSIGN_OR_RETURN(outcome.map, store.ReadGlobalMap());
  outcome.report.fused.map_points = outcome.map.points.size();
  return absl::OkStatus();
}

}  // namespace corbslam
