#include <cstdio>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <system_error>
#include <vector>

#include "services/tool/commands/commands.h"
#include "services/tool/commands/mission_arguments.h"
#include "services/tool/mission/mission_admin.h"
#include "services/tool/mission/mission_json.h"
#include "services/tool/mission/mission_summary.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {
namespace {

absl::Status ListMissions(const MissionArguments& arguments) {
  ASSIGN_OR_RETURN(const auto channel, Connect(arguments));
  MissionAdmin admin(channel);
  ASSIGN_OR_RETURN(const std::vector<v1::Mission> missions, admin.List());
  if (arguments.json) {
    nlohmann::ordered_json json = nlohmann::ordered_json::array();
    for (const v1::Mission& mission : missions) json.push_back(ToJson(mission));
    std::printf("%s\n", json.dump(2).c_str());
    return absl::OkStatus();
  }
  std::printf("%s", FormatMissions(missions).c_str());
  return absl::OkStatus();
}

absl::Status BackUp(const MissionArguments& arguments) {
  ASSIGN_OR_RETURN(const auto channel, Connect(arguments));
  MissionAdmin admin(channel);
  ASSIGN_OR_RETURN(const uint64_t bytes,
                   admin.BackUp(arguments.mission, arguments.file, ShowBytes("written")));
  std::printf("%s: %lu bytes of mission %s\n", arguments.file.c_str(),
              static_cast<unsigned long>(bytes), arguments.mission.c_str());
  return absl::OkStatus();
}

absl::Status Restore(const MissionArguments& arguments) {
  ASSIGN_OR_RETURN(const auto channel, Connect(arguments));
  MissionAdmin admin(channel);
  std::error_code error;
  const uint64_t total = std::filesystem::file_size(arguments.file, error);
  ASSIGN_OR_RETURN(const v1::Mission mission, admin.Restore(arguments.file, arguments.mission,
                                                            ShowBytes("sent", error ? 0 : total)));
  std::printf("%s: %u local maps, %lu keyframes, %lu map points\n", mission.name().c_str(),
              mission.local_maps(), static_cast<unsigned long>(mission.keyframes()),
              static_cast<unsigned long>(mission.map_points()));
  return absl::OkStatus();
}

absl::Status Sleep(const MissionArguments& arguments) {
  ASSIGN_OR_RETURN(const auto channel, Connect(arguments));
  MissionAdmin admin(channel);
  ASSIGN_OR_RETURN(const v1::Mission mission, admin.Sleep(arguments.mission));
  std::printf("mission %s is asleep, with %lu keyframes\n", arguments.mission.c_str(),
              static_cast<unsigned long>(mission.keyframes()));
  return absl::OkStatus();
}

absl::Status Delete(const MissionArguments& arguments) {
  ASSIGN_OR_RETURN(const auto channel, Connect(arguments));
  MissionAdmin admin(channel);
  ASSIGN_OR_RETURN(const uint32_t local_maps, admin.Delete(arguments.mission));
  std::printf("deleted mission %s with %u local maps\n", arguments.mission.c_str(), local_maps);
  return absl::OkStatus();
}

}  // namespace

void AddMissionCommand(CLI::App& app, Command& chosen) {
  auto arguments = std::make_shared<MissionArguments>();
  CLI::App* mission = app.add_subcommand(
      "mission",
      "List, show, create, set up, export, back up, restore, put to sleep and delete missions");
  mission->require_subcommand(1);
  CLI::App* list = AddMissionAction(*mission, "list", "The missions of a map store", &ListMissions,
                                    arguments, chosen);
  AddJsonFlag(*list, *arguments);
  AddShowAction(*mission, arguments, chosen);
  AddSettingActions(*mission, arguments, chosen);
  AddExportAction(*mission, arguments, chosen);
  CLI::App* backup = AddMissionAction(*mission, "backup",
                                      "Write a mission to one file, for another store, while it "
                                      "goes on",
                                      &BackUp, arguments, chosen);
  AddMissionFlag(*backup, *arguments);
  backup->add_option("--out", arguments->file, "File to write; there must be none yet")->required();
  CLI::App* restore = AddMissionAction(*mission, "restore", "Make a mission of such a file",
                                       &Restore, arguments, chosen);
  restore->add_option("--mission", arguments->mission, "Its name; there must be none yet")
      ->required();
  restore->add_option("--file", arguments->file, "What `mission backup` has written")->required();
  CLI::App* sleep = AddMissionAction(*mission, "sleep",
                                     "Have a mission that nobody uses leave the store's memory, "
                                     "until somebody wants it",
                                     &Sleep, arguments, chosen);
  AddMissionFlag(*sleep, *arguments);
  CLI::App* remove =
      AddMissionAction(*mission, "delete", "Forget a mission for good", &Delete, arguments, chosen);
  AddMissionFlag(*remove, *arguments);
}

}  // namespace corbslam::services
