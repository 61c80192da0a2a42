// Says which of a robot's flags its map store may set, and sets them (docs/robot.md).
#ifndef CORBSLAM_SERVICES_PROGRAMS_SETTINGS_FLAGS_H_
#define CORBSLAM_SERVICES_PROGRAMS_SETTINGS_FLAGS_H_

#include <CLI/CLI.hpp>
#include <cstdint>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "corbslam/v1/robot_settings.pb.h"
#include "services/command_line/setting.h"
#include "services/convert/robot_setting_table.h"
#include "slam/exchange/share_modes.h"

namespace corbslam::services {

// What a map store may set.
struct SettableFlags {
  int features = 0;
  double max_rate_hz = 0;
  std::string upload = "features=all";
  uint64_t uplink_kbps = 0;  // 0: no bound.
  // Nullopt: everything, or nearby where memory is bounded.
  std::optional<ShareMode> share;
  std::optional<double> share_radius_m;  // Nullopt: ShareScope's.
  uint64_t memory_budget_bytes = 0;      // Of the process; 0: no bound.
  std::string mask_png;                  // No flag: a store alone sets it.
};

// Their rows; what each number may be stands in services/convert/robot_setting_table.cc, for all
// who set it.
inline std::vector<Setting> RowsOf(SettableFlags& flags) {
  NumberRange features = RangeOfRobotSetting("features");
  features.zero = "the sensor's own";
  return {
      {"--features",
       &flags.features,
       "Features of a picture; 0: 2000 for stereo, 1000 for RGB-D",
       {.in = features}},
      {"--max-rate",
       &flags.max_rate_hz,
       "Frames a second that are tracked at most, by their own times; 0: all",
       {.in = RangeOfRobotSetting("max-rate"), .rare = true}},
      {"--upload", &flags.upload,
       "Of each keyframe: features=all, =mapped or =N; &picture=N: with one for people, N px wide; "
       "0: none"},
      {"--uplink-kbps",
       &flags.uplink_kbps,
       "kbit/s to the map store at most; what is over waits; 0: no bound",
       {.in = RangeOfRobotSetting("uplink-kbps"), .unit = "KBPS"}},
      {"--share", OneOf(kShareModes, &flags.share),
       "What the map store tells the robot: everything, unless said otherwise; nearby (with "
       "--memory-budget unless said otherwise): others' keyframes near it; corrections: where its "
       "own map is in all's; none: nothing, and WatchPose has no global_from_local",
       kRare},
      {"--share-radius",
       &flags.share_radius_m,
       "With --share nearby: how far from the robot's newest keyframe, in metres; without: 50",
       {.in = RangeOfRobotSetting("share-radius"), .unit = "METRES", .rare = true}},
      // The robot's own pictures decide how little is too little.
      {"--memory-budget",
       &flags.memory_budget_bytes,
       "Memory of the process, as 500MB, beyond which far parts of the map leave it for the map "
       "store (without one for --spool) and come back when they are near; 0: no bound",
       {.in = Bytes(0), .rare = true}},
  };
}

struct SettingsFlags {
  std::string key;   // File of the public keys; empty: the store sets nothing.
  std::string kept;  // File for what was taken; empty: none.
};
std::vector<Setting> RowsOf(SettingsFlags& flags);
// INVALID_ARGUMENT for flags that need others.
absl::Status CheckSettingsFlags(const SettingsFlags& flags, bool has_server);
// INVALID_ARGUMENT for a file of keys or of settings that can't be read. A robot does not end
// because of one.
absl::Status CheckSettingsFiles(const SettingsFlags& flags);

// Returns what is shared with a robot whose memory is bounded, or not.
ShareScope ScopeOf(const SettableFlags& flags, bool is_bounded);
// Returns INVALID_ARGUMENT for a radius without --share nearby, and if less than everything is to
// be shared with a robot without a map store.
absl::Status CheckShare(const SettableFlags& flags, bool is_bounded, bool has_server);

// Returns the flags that a store might set, and --outbox-mb, which another value depends on, that
// were set on the command line, in the environment or in a file.
std::set<std::string> GivenFlags(const CLI::App& app);

// Sets what the settings say and nobody gave: first those of all robots, then the robot's own.
// Returns a line for each, in the form of --print-config: "features = 1500  # version 7 of ...",
// and a comment for what is given and stays.
std::vector<std::string> UseSettings(const v1::RobotSettings& of_all, const v1::RobotSettings& own,
                                     const std::set<std::string>& given, SettableFlags& flags);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_PROGRAMS_SETTINGS_FLAGS_H_
