#include "services/tool/commands/mission_arguments.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "services/client/store/store_reader.h"
#include "services/security/flags.h"
#include "services/tool/output/progress.h"
#include "slam/util/atomic_file.h"
#include "slam/util/text_file.h"

namespace corbslam::services {

absl::StatusOr<std::shared_ptr<grpc::Channel>> Connect(const MissionArguments& arguments) {
  if (arguments.mission.empty()) return ConnectToStore(arguments.server, arguments.security);
  return ConnectToStoreOf(arguments.mission, arguments.server, arguments.security);
}

std::function<void(uint64_t bytes)> ShowBytes(const char* what, uint64_t total) {
  return [line = std::make_shared<ProgressLine>(), what, total](uint64_t bytes) {
    line->Tell(absl::StrCat(what, ": ", DescribeBytes(bytes, total)));
  };
}

absl::Status WriteReadme(const std::vector<std::string>& lines, const std::string& file) {
  return IsForPlainFile(file) ? WriteLines(lines, file + ".README.md") : absl::OkStatus();
}

CLI::App* AddMissionAction(CLI::App& mission, const char* name, const char* what,
                           absl::Status (*run)(const MissionArguments&),
                           const std::shared_ptr<MissionArguments>& arguments, Command& chosen) {
  CLI::App* action = mission.add_subcommand(name, what);
  action->add_option("--server", arguments->server, "HOST:PORT of the map store")->required();
  AddTlsFlags(*action, arguments->security);
  AddClientFlags(*action, arguments->security);
  action->callback([run, arguments, &chosen] { chosen = [=] { return run(*arguments); }; });
  return action;
}

void AddMissionFlag(CLI::App& action, MissionArguments& arguments) {
  action.add_option("--mission", arguments.mission, "Its name")->required();
}

void AddJsonFlag(CLI::App& action, MissionArguments& arguments) {
  action.add_flag("--json", arguments.json, "Print JSON, for scripts");
}

void AddYesFlag(CLI::App& action, MissionArguments& arguments) {
  action.add_flag("--yes", arguments.yes, "Do not ask at a terminal whether it is meant");
}

}  // namespace corbslam::services
