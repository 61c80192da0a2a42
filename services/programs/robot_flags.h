// The flags of a robot's program.
#ifndef CORBSLAM_SERVICES_PROGRAMS_ROBOT_FLAGS_H_
#define CORBSLAM_SERVICES_PROGRAMS_ROBOT_FLAGS_H_

#include <CLI/CLI.hpp>
#include <cstdint>
#include <set>
#include <string>

#include "services/programs/default_vocabulary.h"
#include "services/programs/observe_flags.h"
#include "services/programs/record_flags.h"
#include "services/programs/robot/agent_run.h"
#include "services/programs/robot/agent_trajectories.h"
#include "services/programs/settings_flags.h"
#include "services/programs/spool_flags.h"
#include "services/security/flags.h"

namespace corbslam::services {

struct RobotFlags : SettableFlags {
  std::string source;
  std::string rig;
  std::string frames;
  std::string server;
  std::string mission = "default";
  std::string agent = "agent";
  Pace pace = Pace::kMax;
  std::string listen;
  std::string stats;
  std::string held_map;
  std::string trajectory;
  PosesOf poses_of = PosesOf::kRecordedCamera;
  std::string vocabulary = DefaultVocabularyPath();
  uint64_t seed = 0;
  int solver_threads = 1;
  double finish_s = 120;
  SpoolFlags spool;
  uint64_t outbox_mb = 64;
  SettingsFlags settings;
  std::set<std::string> given;  // Of SettableFlags.
  RecordFlags record;
  bool stay = false;
  bool strict = false;
  bool take_over = false;
  bool localise_only = false;
  SecurityOptions security;
  ObserveFlags observe;
  bool listen_insecure = false;
};

void AddRobotFlags(CLI::App& app, RobotFlags& flags);

// Returns the flags with what a map store set in place of theirs.
RobotFlags With(const SettableFlags& set, RobotFlags flags);

// Returns what is shared: less, where nothing is said of it and memory is bounded.
ShareFlags ShareOf(const RobotFlags& flags);

// Returns how the robot itself serves on --listen.
SecurityOptions ListenSecurityOf(const RobotFlags& flags);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_PROGRAMS_ROBOT_FLAGS_H_
