// The table of what a mission's owner may set of its robots from afar, a row for each setting. Who
// signs settings, who stores them and who runs with them reads it.
#ifndef CORBSLAM_SERVICES_CONVERT_ROBOT_SETTING_TABLE_H_
#define CORBSLAM_SERVICES_CONVERT_ROBOT_SETTING_TABLE_H_

#include <cstdint>
#include <string>

#include "absl/status/status.h"
#include "absl/strings/string_view.h"
#include "absl/types/span.h"
#include "corbslam/v1/robot_settings.pb.h"
#include "slam/util/number_range.h"

namespace corbslam::services {

struct RobotSetting {
  const char* flag;   // Of client_agent, without its dashes.
  const char* field;  // Of v1::RobotSettings.
  const char* text;   // What `mission settings` says of it.
  NumberRange in = {};
  // Returns what a text must be that is not `value`; empty if it is good. Null: of a number.
  std::string (*wanted)(const std::string& value) = nullptr;
  // Before the field's text in the flag's.
  const char* prefix = "";
  // The flag of `mission settings` and what its number counts, where they are others than of the
  // robot.
  const char* tool_flag = flag;
  uint64_t tool_unit = 1;
  bool is_file = false;  // Bytes, which `mission settings` reads from a file.
};

// Returns all rows.
absl::Span<const RobotSetting> RobotSettingTable();
// Returns what the flag's number may be.
NumberRange RangeOfRobotSetting(absl::string_view flag);

bool HasSetting(const RobotSetting& row, const v1::RobotSettings& settings);
void ClearSetting(const RobotSetting& row, v1::RobotSettings& settings);
bool IsInteger(const RobotSetting& row);
// These set the value unchecked.
void SetNumber(const RobotSetting& row, double number, v1::RobotSettings& settings);
void SetText(const RobotSetting& row, const std::string& text, v1::RobotSettings& settings);
// Returns the value as the robot's flag is given it, a number in `unit`s; of a file "81 bytes of
// PNG".
std::string SettingText(const RobotSetting& row, const v1::RobotSettings& settings,
                        uint64_t unit = 1);

// No robot keeps to less, whatever its camera is (docs/robot.md): one of the smallest pictures and
// the fewest features, with a map of a few keyframes.
inline constexpr uint64_t kLeastMemoryBudget_bytes = uint64_t{98} << 20;

// INVALID_ARGUMENT names the first field that is out of its bounds, its value and its bounds, or
// two fields that no robot can follow together. Who signs settings, who stores them and who runs
// with them asks the same; what a robot's own camera and flags allow is its own to say.
absl::Status CheckRobotSettings(const v1::RobotSettings& settings);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_CONVERT_ROBOT_SETTING_TABLE_H_
