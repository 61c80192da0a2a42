// Adds `mission settings`.
#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "services/convert/resource_names.h"
#include "services/security/pem_files.h"
#include "services/tool/commands/mission_arguments.h"
#include "services/tool/mission/mission_admin.h"
#include "services/tool/mission/robot_settings.h"
#include "services/tool/output/result.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {
namespace {

void Print(const v1::RobotSettingsList& list) {
  const std::string text = FormatSettings(list);
  PrintResult(text.empty() ? "nothing is set\n" : text, ToJson(list));
}

absl::Status Settings(const MissionArguments& arguments) {
  RETURN_IF_ERROR(CheckNameSegment("NAME", arguments.mission));
  const RobotSettingsFlags& flags = arguments.robot_settings;
  if (!arguments.agent.empty()) RETURN_IF_ERROR(CheckNameSegment("--agent", arguments.agent));
  if (IsEmpty(flags) != flags.key.empty()) {
    return absl::InvalidArgumentError(
        flags.key.empty() ? "robots take settings that are signed: give --sign KEY, too"
                          : "--sign is given, but nothing to be set");
  }
  ASSIGN_OR_RETURN(const auto channel, Connect(arguments));
  MissionAdmin admin(channel);
  const std::string name = arguments.agent.empty() ? MissionName(arguments.mission)
                                                   : AgentName(arguments.mission, arguments.agent);
  ASSIGN_OR_RETURN(const v1::RobotSettingsList now, admin.GetSettings(name));
  if (IsEmpty(flags)) {
    Print(now);
    return absl::OkStatus();
  }
  ASSIGN_OR_RETURN(const std::string key, ReadSecurityFile("--sign", flags.key));
  ASSIGN_OR_RETURN(const v1::SignedRobotSettings made,
                   MakeSettings(flags, arguments.mission, arguments.agent,
                                FindSettings(now, arguments.agent), key, absl::Now()));
  ASSIGN_OR_RETURN(const v1::RobotSettingsList set, admin.SetSettings(name, made));
  Print(set);
  return absl::OkStatus();
}

void AddFlags(CLI::App& action, RobotSettingsFlags& flags) {
  for (const RobotSetting& row : RobotSettingTable()) {
    const auto take = [&flags, &row](const std::string& text) -> std::string {
      flags.given[row.tool_flag] = text;
      v1::RobotSettings settings;
      return row.is_file ? "" : PutSetting(row, text, settings);
    };
    action
        .add_option_function<std::string>(
            absl::StrCat("--", row.tool_flag), [](const std::string&) {}, row.text)
        ->check(CLI::Validator([take](std::string& text) { return take(text); }, ""))
        ->type_name(row.wanted == nullptr ? "NUMBER" : "TEXT");
  }
  action.add_option("--unset", flags.unset, "Flag of these, without dashes, that is set no more")
      ->allow_extra_args(false);
  action.add_option("--sign", flags.key, "PEM file of the Ed25519 private key that signs");
  action.add_flag("--replace", flags.replace,
                  "Take nothing over from what the map store has, whoever signed that");
}

}  // namespace

void AddRobotSettingsAction(CLI::App& mission, const std::shared_ptr<MissionArguments>& arguments,
                            Command& chosen) {
  CLI::App* action = AddMissionAction(mission, "settings",
                                      "Show, or sign and set, what the mission's robots run with",
                                      &Settings, arguments, chosen);
  action->add_option("NAME,--mission", arguments->mission, "The mission")->required();
  action->add_option("--agent", arguments->agent, "This robot alone; without: all");
  AddFlags(*action, arguments->robot_settings);
  AddJsonFlag(*action, *arguments);
}

}  // namespace corbslam::services
