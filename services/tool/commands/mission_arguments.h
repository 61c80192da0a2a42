// Holds what the commands for the missions of a running store share.
#ifndef CORBSLAM_SERVICES_TOOL_COMMANDS_MISSION_ARGUMENTS_H_
#define CORBSLAM_SERVICES_TOOL_COMMANDS_MISSION_ARGUMENTS_H_

#include <grpcpp/channel.h>

#include <CLI/CLI.hpp>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "services/security/security_options.h"
#include "services/tool/commands/commands.h"
#include "services/tool/mission/mission_settings.h"
#include "services/tool/mission/robot_settings.h"

namespace corbslam::services {

struct MissionArguments {
  std::string server;
  SecurityOptions security;
  std::string mission;
  std::string file;
  bool json = false;
  bool yes = false;                   // Of `delete` and `forget`: nobody is asked.
  MissionSettings settings;           // Of `create` and `set`.
  RobotSettingsFlags robot_settings;  // Of `settings`.
  // These are of stored backups: missions/M/backups/N, a time, and a new mission's name.
  std::string stored;
  std::string at;
  std::string as;
  // These are of `backup-all`.
  std::string folder;
  size_t keep = 7;
  std::string agent;  // Of `export`, `settings` and `forget`.
  // These are of `forget`.
  std::string before;
  std::optional<uint32_t> keep_local_maps;
  bool dry_run = false;
  // `export` alone has the four fields below.
  std::string format;
  std::string clock;
  std::string poses_of;  // Empty if the flag was not given.
  uint32_t moments = 0;  // 0 if the flag was not given.
};

// Opens a channel to the store that the flags name, or to the one that has their mission.
absl::StatusOr<std::shared_ptr<grpc::Channel>> Connect(const MissionArguments& arguments);

// Returns a function that shows the bytes so far (progress.h), of a `total` that may be unknown
// (0).
std::function<void(uint64_t bytes)> ShowBytes(const char* what, uint64_t total = 0);

// Writes the lines to FILE.README.md, beside what was exported; there is none beside a device or a
// pipe.
absl::Status WriteReadme(const std::vector<std::string>& lines, const std::string& file);

// Adds a command below `mission`, with the flags that say which store.
CLI::App* AddMissionAction(CLI::App& mission, const char* name, const char* what,
                           absl::Status (*run)(const MissionArguments&),
                           const std::shared_ptr<MissionArguments>& arguments, Command& chosen);
void AddMissionFlag(CLI::App& action, MissionArguments& arguments);
void AddJsonFlag(CLI::App& action, MissionArguments& arguments);
void AddYesFlag(CLI::App& action, MissionArguments& arguments);

// These add `mission create` and `mission set`; `mission settings`; `mission show`; and `mission
// export`.
void AddSettingActions(CLI::App& mission, const std::shared_ptr<MissionArguments>& arguments,
                       Command& chosen);
void AddRobotSettingsAction(CLI::App& mission, const std::shared_ptr<MissionArguments>& arguments,
                            Command& chosen);
void AddShowAction(CLI::App& mission, const std::shared_ptr<MissionArguments>& arguments,
                   Command& chosen);
void AddExportAction(CLI::App& mission, const std::shared_ptr<MissionArguments>& arguments,
                     Command& chosen);
// Adds `mission forget`.
void AddForgetAction(CLI::App& mission, const std::shared_ptr<MissionArguments>& arguments,
                     Command& chosen);
// These add `mission restore`, and the commands for backups that the store keeps.
void AddRestoreAction(CLI::App& mission, const std::shared_ptr<MissionArguments>& arguments,
                      Command& chosen);
void AddBackupActions(CLI::App& mission, const std::shared_ptr<MissionArguments>& arguments,
                      Command& chosen);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_TOOL_COMMANDS_MISSION_ARGUMENTS_H_
