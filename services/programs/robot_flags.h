// The flags of a robot's program.
#ifndef CORBSLAM_SERVICES_PROGRAMS_ROBOT_FLAGS_H_
#define CORBSLAM_SERVICES_PROGRAMS_ROBOT_FLAGS_H_

#include <CLI/CLI.hpp>
#include <cstdint>
#include <set>
#include <string>

#include "services/programs/default_vocabulary.h"
#include "services/programs/memory_needs.h"
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
  std::string told;
  std::string trajectory;
  PosesOf poses_of = PosesOf::kRecordedCamera;
  std::string vocabulary = DefaultVocabularyPath();
  uint64_t seed = 0;
  int solver_threads = 1;
  uint64_t downlink_kbps = 0;  // 0: no bound.
  double finish_s = 120;
  SpoolFlags spool;
  // Counts if it was given; else OutboxBytesOf does.
  uint64_t outbox_mb = 64;
  SettingsFlags settings;
  std::set<std::string> given;  // GivenFlags.
  RecordFlags record;
  bool stay = false;
  bool strict = false;
  bool take_over = false;
  bool localise_only = false;
  SecurityOptions security;
  ObserveFlags observe;
  bool listen_insecure = false;
  // Not a flag: the size of the source's pictures, once it is open; 0 before.
  int width_px = 0;
  int height_px = 0;
  bool has_depth = false;  // They are of an RGB-D camera.
};

// Returns AgentOptions' features of a picture and bytes of the outbox.
int FeaturesOf(const RobotFlags& flags);
uint64_t OutboxBytesOf(const RobotFlags& flags);
// Returns what bounds the robot's memory from below.
MemoryNeeds MemoryNeedsOf(const RobotFlags& flags);

constexpr uint64_t BytesPerSecond(uint64_t kbps) { return kbps * 125; }

void AddRobotFlags(CLI::App& app, RobotFlags& flags);

// Returns the flags with what a map store set in place of theirs.
RobotFlags With(const SettableFlags& set, RobotFlags flags);

// Whether the robot leaves far parts of its map with a map store.
bool IsBounded(const RobotFlags& flags);

// Returns how the robot itself serves on --listen.
SecurityOptions ListenSecurityOf(const RobotFlags& flags);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_PROGRAMS_ROBOT_FLAGS_H_
