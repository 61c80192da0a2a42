#include <glog/logging.h>

#include <string>
#include <vector>

#include "absl/strings/escaping.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "services/convert/resource_names.h"
#include "services/convert/robot_setting_table.h"
#include "services/map_store_service/map_store_service.h"
#include "services/map_store_service/settings_to_proto.h"
#include "services/observe/logging/log_fields.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {

using map_store::MissionInfo;
using map_store::SignedSettings;

namespace {

// Reads missions/{mission}/agents/{agent}, or missions/{mission} for all agents (empty).
absl::StatusOr<AgentPath> ParseWhose(const std::string& name) {
  if (absl::StrContains(name, "/agents/")) return ParseAgentName(name, /*may_be_all=*/false);
  ASSIGN_OR_RETURN(const std::string mission, ParseMissionName(name));
  return AgentPath{mission, ""};
}

// Reads settings that robots could run with: the store does not keep others, which would end or
// confuse every robot that is told them. It has no keys: who signed them it can't tell.
absl::StatusOr<SignedSettings> SettingsFromProto(const v1::SignedRobotSettings& proto,
                                                 const AgentPath& whose) {
  v1::RobotSettings settings;
  if (proto.settings().size() > map_store::kMaxSettingsBytes) {
    return absl::InvalidArgumentError(absl::StrCat("settings.settings has ",
                                                   proto.settings().size(), " bytes, at most ",
                                                   map_store::kMaxSettingsBytes, " are allowed"));
  }
  if (!settings.ParseFromString(proto.settings())) {
    return absl::InvalidArgumentError("settings.settings can't be read as a RobotSettings");
  }
  RETURN_IF_ERROR(CheckRobotSettings(settings));
  if (settings.mission() != MissionName(whose.mission) || settings.agent() != whose.agent) {
    return absl::InvalidArgumentError(absl::StrCat(
        "the signed settings are of mission \"", absl::CHexEscape(settings.mission().substr(0, 80)),
        "\" and agent \"", absl::CHexEscape(settings.agent().substr(0, 80)),
        "\", must be those of name: \"", MissionName(whose.mission), "\" and \"", whose.agent,
        "\""));
  }
  return SignedSettings{settings.version(), proto.settings(), proto.signature()};
}

v1::RobotSettingsList SettingsOf(const AgentPath& whose, const MissionInfo& info) {
  std::vector<SignedSettings> found;
  const auto take = [&](const std::string& agent) {
    const auto entry = info.profile.robot_settings.find(agent);
    if (entry != info.profile.robot_settings.end()) found.push_back(entry->second);
  };
  take("");
  if (!whose.agent.empty()) take(whose.agent);
  return ToProto(found);
}

}  // namespace

v1::RobotSettingsList ToProto(const std::vector<SignedSettings>& settings) {
  v1::RobotSettingsList list;
  for (const SignedSettings& entry : settings) {
    v1::SignedRobotSettings& proto = *list.add_settings();
    proto.set_settings(entry.bytes);
    proto.set_signature(entry.signature);
  }
  return list;
}

absl::Status MapStoreService::SetRobotSettings(const v1::SetRobotSettingsRequest& request,
                                               v1::RobotSettingsList* response) {
  ASSIGN_OR_RETURN(const AgentPath whose, ParseWhose(request.name()));
  ASSIGN_OR_RETURN(const SignedSettings settings, SettingsFromProto(request.settings(), whose));
  RETURN_IF_ERROR(store_.SetRobotSettings(whose.mission, whose.agent, settings));
  LOG(INFO) << LogFields{.mission = whose.mission, .agent = whose.agent}
            << "robots' settings changed: version " << settings.version;
  ASSIGN_OR_RETURN(const MissionInfo info, store_.GetMission(whose.mission));
  *response = SettingsOf(whose, info);
  return absl::OkStatus();
}

absl::Status MapStoreService::GetRobotSettings(const v1::GetRobotSettingsRequest& request,
                                               v1::RobotSettingsList* response) {
  ASSIGN_OR_RETURN(const AgentPath whose, ParseWhose(request.name()));
  ASSIGN_OR_RETURN(const MissionInfo info, store_.GetMission(whose.mission));
  *response = SettingsOf(whose, info);
  return absl::OkStatus();
}

}  // namespace corbslam::services
