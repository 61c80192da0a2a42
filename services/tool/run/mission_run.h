// Lets robots map a mission, and reads what came of it.
#ifndef CORBSLAM_SERVICES_TOOL_RUN_MISSION_RUN_H_
#define CORBSLAM_SERVICES_TOOL_RUN_MISSION_RUN_H_

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "client_agent/map/near_map.h"
#include "services/client/store/local_map_names.h"
#include "services/client/store/served_mission.h"
#include "services/client/store/store_reader.h"
#include "services/security/security_options.h"
#include "services/tool/evaluation/accuracy.h"
#include "services/tool/report/report.h"
#include "services/tool/report/shown_mission.h"
#include "services/tool/run/plan.h"

namespace corbslam::services {

struct MissionRunOptions {
  std::string mission = "demo";
  std::vector<RobotPlan> robots;
  // True: the robots play one after the other instead of all at once.
  bool sequential = false;
  // True: the robots bring their maps as ever, but are told nothing of what others made, as with
  // client_agent --share none.
  bool alone = false;
  // Seeds local map ids and every random choice. Nullopt: 1 in lockstep, another number each time
  // for processes, so that a mission can be taken up again.
  std::optional<uint64_t> seed;
  std::string vocabulary_path;  // Empty: the one that ships.
  // Address of a running map store, for processes only. Empty: a store is started, with a worker.
  std::string server;
  // Security towards that store, for this process and the agents. Servers that are started here
  // listen on loopback without TLS.
  SecurityOptions security;
  std::string pace = "max";
  std::string log_folder;
  // True: robots refuse a source in which something looks wrong.
  bool strict = false;
  // True: a map viewer shows the mission while it runs, for processes only; its address is printed.
  bool view = false;
  // File with where the robots' cameras really were, in TUM's format, for that viewer; may be
  // empty.
  std::string truth_path;
  // How long the store may take to fuse after the last robot ended.
  absl::Duration fusion_timeout = absl::Minutes(20);
};

// Holds what a run left behind, with everything of the report but accuracy.
struct MissionOutcome {
  RunReport report;
  std::vector<RobotPaths> paths;  // In the order of the robots.
  ServedMap map;
  LocalMapNames local_map_names;
  ShownMission recorded;
  // What each robot held in the end, its own map and what came of others', in its local map's
  // frame; in the order of the robots. Nullopt for one that never had a pose or left nothing.
  std::vector<std::optional<client_agent::NearMap>> held;
  // What went wrong with single robots: "alpha: ...". The others' results are still valid.
  std::vector<std::string> failures;
};

// Holds the frames done so far, by robot, which a progress line shows.
struct Progress {
  std::string stage;
  // The robot's name, and frames as "54/121".
  std::vector<std::pair<std::string, std::string>> robots;
};
using ProgressListener = std::function<void(const Progress&)>;

// Runs map store, fusion worker and agents as a process each. Errors name the process and show the
// end of its log.
absl::StatusOr<MissionOutcome> RunProcesses(const MissionRunOptions& options,
                                            const ProgressListener& on_progress);

// Runs all in this process, in lockstep, on one thread: every agent takes a frame, then the store
// fuses until it is idle, then shared updates go to the agents in the order of the robots. The
// result is the same to the bit every time.
absl::StatusOr<MissionOutcome> RunLockstep(const MissionRunOptions& options,
                                           const ProgressListener& on_progress);

// Fills paths, map and what the store's statistics know. Where no robot brought anything, the store
// knows no such mission: the outcome is empty then, and so are the paths of a robot of which it
// knows nothing.
absl::Status ReadOutcome(StoreReader& store, const MissionRunOptions& options,
                         MissionOutcome& outcome);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_TOOL_RUN_MISSION_RUN_H_
