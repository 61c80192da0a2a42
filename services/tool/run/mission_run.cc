#include "services/tool/run/mission_run.h"

#include <glog/logging.h>

#include <utility>

#include "services/tool/report/store_statistics.h"
#include "services/tool/run/record_mission.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {

namespace {

// Returns an empty path if the store knows nothing of the robot.
absl::StatusOr<ServedTrajectory> ReadPath(StoreReader& store, const std::string& robot,
                                          v1::TrajectoryFrame frame) {
  absl::StatusOr<ServedTrajectory> path = store.ReadTrajectory(robot, frame);
  return absl::IsNotFound(path.status()) ? ServedTrajectory() : std::move(path);
}

// Fills the outcome if the store has the mission.
absl::Status ReadMission(StoreReader& store, const MissionRunOptions& options,
                         MissionOutcome& outcome) {
  absl::StatusOr<v1::GetStatisticsResponse> statistics = store.Statistics();
  if (absl::IsNotFound(statistics.status())) return absl::OkStatus();
  RETURN_IF_ERROR(statistics.status());
  AddStatistics(statistics->mission(), outcome.report);
  ASSIGN_OR_RETURN(outcome.map, store.ReadGlobalMap());
  outcome.report.fused.map_points = outcome.map.points.size();
  ASSIGN_OR_RETURN(const std::vector<v1::LocalMap> local_maps, store.ListLocalMaps());
  outcome.local_map_names = ShortNames(local_maps);
  // Another one's store may have to replay far more than this run.
  RecordOptions how{.has_journal = options.view && options.server.empty()};
  for (const RobotPlan& robot : options.robots) how.robots.push_back(robot.name);
  absl::StatusOr<ShownMission> recorded = RecordMission(store, options.mission, how);
  LOG_IF(WARNING, !recorded.ok()) << "report.html has the map from above alone: "
                                  << recorded.status();
  if (recorded.ok()) outcome.recorded = *std::move(recorded);
  return absl::OkStatus();
}

}  // namespace

absl::Status ReadOutcome(StoreReader& store, const MissionRunOptions& options,
                         MissionOutcome& outcome) {
  RETURN_IF_ERROR(ReadMission(store, options, outcome));
  for (const RobotPlan& robot : options.robots) {
    RobotPaths paths;
    paths.name = robot.name;
    paths.source = robot.source;
    ASSIGN_OR_RETURN(paths.local, ReadPath(store, robot.name, v1::TRAJECTORY_FRAME_LOCAL));
    ASSIGN_OR_RETURN(paths.global, ReadPath(store, robot.name, v1::TRAJECTORY_FRAME_GLOBAL));
    outcome.paths.push_back(std::move(paths));
  }
  return absl::OkStatus();
}

}  // namespace corbslam::services
