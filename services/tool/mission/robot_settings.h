// Makes what an operator signs for a mission's robots, and describes for people what is set.
#ifndef CORBSLAM_SERVICES_TOOL_MISSION_ROBOT_SETTINGS_H_
#define CORBSLAM_SERVICES_TOOL_MISSION_ROBOT_SETTINGS_H_

#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "corbslam/v1/robot_settings.pb.h"
#include "services/convert/robot_setting_table.h"

namespace corbslam::services {

// Has what was given on the command line.
struct RobotSettingsFlags {
  // Values as texts, by their rows' tool_flag (services/convert/robot_setting_table.h).
  std::map<std::string, std::string> given = {};
  std::vector<std::string> unset = {};  // The same names.
  bool replace = false;
  std::string key = {};  // File of the private key.
};

// Returns whether nothing is to be changed.
bool IsEmpty(const RobotSettingsFlags& flags);

// Puts a value, as `mission settings` is given it, and returns what is wrong with it, if no robot
// takes it: value and bounds; empty if it is good. Not for files.
std::string PutSetting(const RobotSetting& row, const std::string& text,
                       v1::RobotSettings& settings);

// Finds the settings of this agent (empty: of all robots) in a list; null if there are none.
const v1::SignedRobotSettings* FindSettings(const v1::RobotSettingsList& list,
                                            const std::string& agent);

// Makes of the settings that the store has, or of none, those that are to be signed: what was not
// given stays. The new version is the time in seconds, or one more than the last if that is not
// newer. PERMISSION_DENIED where the store's are not signed by `private_key_pem`: nobody is to sign
// what a store made up; with `replace` they are left out, but for their version.
absl::StatusOr<v1::SignedRobotSettings> MakeSettings(
    const RobotSettingsFlags& flags, const std::string& mission, const std::string& agent,
    const v1::SignedRobotSettings* now, const std::string& private_key_pem, absl::Time time);

// Says what is set, a line for each setting; its signature is not checked.
std::string FormatSettings(const v1::RobotSettingsList& list);
nlohmann::ordered_json ToJson(const v1::RobotSettingsList& list);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_TOOL_MISSION_ROBOT_SETTINGS_H_
