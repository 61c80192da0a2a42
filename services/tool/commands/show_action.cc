#include <cstdio>

#include "services/convert/resource_names.h"
#include "services/tool/commands/mission_arguments.h"
#include "services/tool/mission/mission_summary.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {
namespace {

absl::Status Show(const MissionArguments& arguments) {
  RETURN_IF_ERROR(CheckNameSegment("--mission", arguments.mission));
  ASSIGN_OR_RETURN(const auto channel, Connect(arguments));
  ASSIGN_OR_RETURN(const MissionSummary summary, ReadSummary(channel, arguments.mission));
  std::fputs(
      arguments.json ? (ToJson(summary).dump(2) + "\n").c_str() : FormatSummary(summary).c_str(),
      stdout);
  return absl::OkStatus();
}

}  // namespace

void AddShowAction(CLI::App& mission, const std::shared_ptr<MissionArguments>& arguments,
                   Command& chosen) {
  CLI::App* show =
      AddMissionAction(mission, "show", "Robots, local maps, and what was fused or why not", &Show,
                       arguments, chosen);
  AddMissionFlag(*show, *arguments);
  AddJsonFlag(*show, *arguments);
}

}  // namespace corbslam::services
