#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <system_error>
#include <vector>

#include "absl/strings/str_cat.h"
#include "services/tool/commands/commands.h"
#include "services/tool/commands/mission_arguments.h"
#include "services/tool/mission/mission_admin.h"
#include "services/tool/mission/mission_json.h"
#include "services/tool/mission/mission_summary.h"
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

absl::Status Restore(const MissionArguments& arguments) {
  ASSIGN_OR_RETURN(const auto channel, Connect(arguments));
  MissionAdmin admin(channel);
  std::error_code error;
  const uint64_t total = std::filesystem::file_size(arguments.file, error);
  ASSIGN_OR_RETURN(const v1::Mission mission, admin.Restore(arguments.file, arguments.mission,
                                                            ShowBytes("sent", error ? 0 : total)));
  PrintResult(
      absl::StrCat(mission.name(), ": ", mission.local_maps(), " local maps, ", mission.keyframes(),
                   " keyframes, ", mission.map_points(), " map points\n"),
      ToJson(mission));
  return absl::OkStatus();
}

absl::Status Delete(const MissionArguments& arguments) {
  ASSIGN_OR_RETURN(const auto channel, Connect(arguments));
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
      app.add_subcommand("mission", "List, show, export, back up, restore and delete missions");
  mission->require_subcommand(1);
  CLI::App* list = AddMissionAction(*mission, "list", "The missions of a map store", &ListMissions,
                                    arguments, chosen);
  AddJsonFlag(*list, *arguments);
  AddShowAction(*mission, arguments, chosen);
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
  CLI::App* remove =
      AddMissionAction(*mission, "delete", "Forget a mission for good", &Delete, arguments, chosen);
  AddMissionFlag(*remove, *arguments);
}

}  // namespace corbslam::services
