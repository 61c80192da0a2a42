#include <unistd.h>

#include <cstdio>
#include <filesystem>
#include <memory>

#include "absl/strings/str_cat.h"
#include "services/corbslam/commands.h"
#include "services/corbslam/mission_admin.h"
#include "services/corbslam/store_reader.h"
#include "services/security/flags.h"
#include "services/security/security_options.h"
#include "slam/util/status_macros.h"

namespace corbslam {
namespace {

struct MissionArguments {
  std::string server;
  SecurityOptions security;
  std::string mission;
  std::string file;
};

absl::StatusOr<MissionAdmin> Connect(const MissionArguments& arguments) {
  ASSIGN_OR_RETURN(const auto credentials, MakeChannelCredentials(arguments.security));
  ASSIGN_OR_RETURN(const auto channel, ConnectToStore(arguments.server, credentials));
  return MissionAdmin(channel);
}

// Nothing where nobody looks.
MissionAdmin::Progress ShowBytes(const char* what) {
  if (isatty(STDERR_FILENO) == 0) return nullptr;
  return [what](uint64_t bytes) {
    std::fprintf(stderr, "\r%s: %.1f MB ", what, 1e-6 * static_cast<double>(bytes));
  };
}

absl::Status ListMissions(const MissionArguments& arguments) {
  ASSIGN_OR_RETURN(MissionAdmin admin, Connect(arguments));
  ASSIGN_OR_RETURN(const std::vector<v1::Mission> missions, admin.List());
  std::printf("%-40s %6s %6s %7s %9s %9s %8s %s\n", "mission", "agents", "maps", "islands",
              "keyframes", "points", "revision", "fusion");
  for (const v1::Mission& mission : missions) {
    std::printf(
        "%-40s %6u %6u %7u %9lu %9lu %8lu %s\n", mission.name().c_str(), mission.agents(),
        mission.local_maps(), mission.islands(), static_cast<unsigned long>(mission.keyframes()),
        static_cast<unsigned long>(mission.map_points()),
        static_cast<unsigned long>(mission.revision()), mission.fusion_idle() ? "idle" : "busy");
  }
  return absl::OkStatus();
}

absl::Status BackUp(const MissionArguments& arguments) {
  ASSIGN_OR_RETURN(MissionAdmin admin, Connect(arguments));
  ASSIGN_OR_RETURN(const uint64_t bytes,
                   admin.BackUp(arguments.mission, arguments.file, ShowBytes("written")));
  std::printf("%s: %lu bytes of mission %s\n", arguments.file.c_str(),
              static_cast<unsigned long>(bytes), arguments.mission.c_str());
  return absl::OkStatus();
}

absl::Status Restore(const MissionArguments& arguments) {
  ASSIGN_OR_RETURN(MissionAdmin admin, Connect(arguments));
  ASSIGN_OR_RETURN(const v1::Mission mission,
                   admin.Restore(arguments.file, arguments.mission, ShowBytes("sent")));
  std::printf("%s: %u local maps, %lu keyframes, %lu map points\n", mission.name().c_str(),
              mission.local_maps(), static_cast<unsigned long>(mission.keyframes()),
              static_cast<unsigned long>(mission.map_points()));
  return absl::OkStatus();
}

absl::Status Delete(const MissionArguments& arguments) {
  ASSIGN_OR_RETURN(MissionAdmin admin, Connect(arguments));
  ASSIGN_OR_RETURN(const uint32_t local_maps, admin.Delete(arguments.mission));
  std::printf("deleted mission %s with %u local maps\n", arguments.mission.c_str(), local_maps);
  return absl::OkStatus();
}

CLI::App* AddAction(CLI::App& app, const char* name, const char* what,
                    absl::Status (*run)(const MissionArguments&),
                    const std::shared_ptr<MissionArguments>& arguments, Command& chosen) {
  CLI::App* action = app.add_subcommand(name, what);
  action->add_option("--server", arguments->server, "HOST:PORT of the map store")->required();
  AddTlsFlags(*action, arguments->security);
  AddClientFlags(*action, arguments->security);
  action->callback([run, arguments, &chosen] { chosen = [=] { return run(*arguments); }; });
  return action;
}

}  // namespace

void AddMissionCommand(CLI::App& app, Command& chosen) {
  auto arguments = std::make_shared<MissionArguments>();
  CLI::App* mission = app.add_subcommand("mission", "List, back up, restore and delete missions");
  mission->require_subcommand(1);
  AddAction(*mission, "list", "The missions of a map store", &ListMissions, arguments, chosen);
  CLI::App* backup = AddAction(*mission, "backup", "Write a mission to one file, while it goes on",
                               &BackUp, arguments, chosen);
  backup->add_option("--mission", arguments->mission, "Its name")->required();
  backup->add_option("--out", arguments->file, "File to write; there must be none yet")->required();
  CLI::App* restore =
      AddAction(*mission, "restore", "Make a mission of such a file", &Restore, arguments, chosen);
  restore->add_option("--mission", arguments->mission, "Its name; there must be none yet")
      ->required();
  restore->add_option("--file", arguments->file, "What `mission backup` has written")->required();
  CLI::App* remove =
      AddAction(*mission, "delete", "Forget a mission for good", &Delete, arguments, chosen);
  remove->add_option("--mission", arguments->mission, "Its name")->required();
}

}  // namespace corbslam
