#include <memory>
#include <nlohmann/json.hpp>
#include <vector>

#include "absl/strings/str_cat.h"
#include "services/tool/commands/commands.h"
#include "services/tool/commands/mission_arguments.h"
#include "services/tool/mission/mission_admin.h"
#include "services/tool/mission/mission_json.h"
#include "services/tool/mission/mission_summary.h"
#include "services/tool/output/confirmation.h"
#include "services/tool/output/result.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {
namespace {

absl::Status ListMissions(const MissionArguments& arguments) {
  ASSIGN_OR_RETURN(const auto channel, Connect(arguments));
  MissionAdmin admin(channel);
  ASSIGN_OR_RETURN(const std::vector<v1::Mission> missions, admin.List());
  nlohmann::ordered_json json = nlohmann::ordered_json::array();
  for (const v1::Mission& mission : missions) json.push_back(ToJson(mission));
  PrintResult(FormatMissions(missions), json);
  return absl::OkStatus();
}

absl::Status BackUp(const MissionArguments& arguments) {
  ASSIGN_OR_RETURN(const auto channel, Connect(arguments));
  MissionAdmin admin(channel);
  ASSIGN_OR_RETURN(const uint64_t bytes,
                   admin.BackUp(arguments.mission, arguments.file, ShowBytes("written")));
  PrintResult(
      absl::StrCat(arguments.file, ": ", bytes, " bytes of mission ", arguments.mission, "\n"),
      {{"file", arguments.file}, {"bytes", bytes}, {"mission", arguments.mission}});
  return absl::OkStatus();
}

absl::Status Sleep(const MissionArguments& arguments) {
  ASSIGN_OR_RETURN(const auto channel, Connect(arguments));
  MissionAdmin admin(channel);
  ASSIGN_OR_RETURN(const v1::Mission mission, admin.Sleep(arguments.mission));
  PrintResult(absl::StrCat("mission ", arguments.mission, " is asleep, with ", mission.keyframes(),
                           " keyframes\n"),
              ToJson(mission));
  return absl::OkStatus();
}

absl::Status Delete(const MissionArguments& arguments) {
  ASSIGN_OR_RETURN(const auto channel, Connect(arguments));
  RETURN_IF_ERROR(ConfirmLoss(absl::StrCat("Mission ", arguments.mission, " at ", arguments.server,
                                           " goes for good, for its robots, too; `mission backup` "
                                           "would keep it."),
                              arguments.yes));
  MissionAdmin admin(channel);
  ASSIGN_OR_RETURN(const uint32_t local_maps, admin.Delete(arguments.mission));
  PrintResult(
      absl::StrCat("deleted mission ", arguments.mission, " with ", local_maps, " local maps\n"),
      {{"mission", arguments.mission}, {"local_maps", local_maps}});
  return absl::OkStatus();
}

}  // namespace

void AddMissionCommand(CLI::App& app, Command& chosen) {
  auto arguments = std::make_shared<MissionArguments>();
  CLI::App* mission =
      app.add_subcommand("mission",
                         "List, show, create, set up, export, back up, restore, "
                         "archive, put to sleep and delete missions, and old sessions");
  mission->require_subcommand(1);
  CLI::App* list = AddMissionAction(*mission, "list", "The missions of a map store", &ListMissions,
                                    arguments, chosen);
  AddJsonFlag(*list, *arguments);
  AddRobotSettingsAction(*mission, arguments, chosen);
  AddShowAction(*mission, arguments, chosen);
  AddSettingActions(*mission, arguments, chosen);
  AddExportAction(*mission, arguments, chosen);
  CLI::App* backup = AddMissionAction(*mission, "backup",
                                      "Write a mission to one file, for another store, while it "
                                      "goes on",
                                      &BackUp, arguments, chosen);
  AddMissionFlag(*backup, *arguments);
  backup->add_option("--out", arguments->file, "File to write; there must be none yet")->required();
  AddRestoreAction(*mission, arguments, chosen);
  AddBackupActions(*mission, arguments, chosen);
  CLI::App* sleep = AddMissionAction(*mission, "sleep",
                                     "Have a mission that nobody uses leave the store's memory, "
                                     "until somebody wants it",
                                     &Sleep, arguments, chosen);
  AddMissionFlag(*sleep, *arguments);
  AddForgetAction(*mission, arguments, chosen);
  CLI::App* remove =
      AddMissionAction(*mission, "delete", "Forget a mission for good", &Delete, arguments, chosen);
  AddMissionFlag(*remove, *arguments);
  AddYesFlag(*remove, *arguments);
}

}  // namespace corbslam::services
