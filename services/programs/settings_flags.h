// Says which of a robot's flags its map store may set, and sets them (docs/robot.md).
#ifndef CORBSLAM_SERVICES_PROGRAMS_SETTINGS_FLAGS_H_
#define CORBSLAM_SERVICES_PROGRAMS_SETTINGS_FLAGS_H_

#include <CLI/CLI.hpp>
#include <set>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "corbslam/v1/robot_settings.pb.h"
#include "services/programs/link_flags.h"
#include "services/programs/memory_flags.h"
#include "services/programs/share_flags.h"

namespace corbslam::services {

struct SettingsFlags {
  std::string key;   // File of the public keys; empty: the store sets nothing.
  std::string kept;  // File for what was taken; empty: none.
};

// What a map store may set.
struct SettableFlags {
  int features = 0;
  double max_rate_hz = 0;
  std::string upload = "features=all";
  LinkFlags link;
  ShareFlags share;
  MemoryFlags memory;
  // A PNG; set by a store alone.
  std::string mask_png;
};

// Adds --settings-key and --settings-kept, and --max-rate; --help-all shows them.
void AddSettingsFlags(CLI::App& app, SettingsFlags& flags, double& max_rate_hz);
// INVALID_ARGUMENT for flags that need others.
absl::Status CheckSettingsFlags(const SettingsFlags& flags, bool has_server);
// INVALID_ARGUMENT for a file of keys or of settings that can't be read. A robot does not end
// because of one.
absl::Status CheckSettingsFiles(const SettingsFlags& flags);

// Returns the flags that a store might set, and --outbox-mb, which another value depends on, that
// were set on the command line, in the environment or in a file.
std::set<std::string> GivenFlags(const CLI::App& app);

// Sets what the settings say and nobody gave: first those of all robots, then the robot's own.
// Returns a line for each, in the form of --print-config: "features = 1500  # version 7 of ...",
// and a comment for what is given and stays.
std::vector<std::string> UseSettings(const v1::RobotSettings& of_all, const v1::RobotSettings& own,
                                     const std::set<std::string>& given, SettableFlags& flags);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_PROGRAMS_SETTINGS_FLAGS_H_
