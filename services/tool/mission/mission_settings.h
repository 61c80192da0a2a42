// Turns what people write on the command line about a mission into messages of the contract, and
// back into text.
#ifndef CORBSLAM_SERVICES_TOOL_MISSION_MISSION_SETTINGS_H_
#define CORBSLAM_SERVICES_TOOL_MISSION_MISSION_SETTINGS_H_

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "corbslam/v1/map_store_service.pb.h"

namespace corbslam::services {

// Has what was given; nullopt and empty lists: nothing was.
struct MissionSettings {
  std::optional<std::string> description = std::nullopt;
  std::vector<std::string> labels = {};         // KEY=VALUE
  std::vector<std::string> remove_labels = {};  // KEY
  // Whose the limits are; empty: the mission's.
  std::string agent = {};
  // 0: no limit.
  std::optional<uint64_t> max_keyframes = std::nullopt;
  std::optional<uint64_t> max_memory_mb = std::nullopt;  // MiB, as the next one.
  std::optional<uint64_t> max_disk_mb = std::nullopt;
  std::optional<uint64_t> uplink_kbps = std::nullopt;  // Kilobits a second.
  std::optional<std::string> retention = std::nullopt;
  std::optional<std::string> origin = std::nullopt;
};

// Returns whether nothing was given.
bool IsEmpty(const MissionSettings& settings);

// Reads "30d", "12h", "90m", "45s" or "never"; a number without a unit gets INVALID_ARGUMENT, as it
// might be meant in any.
absl::StatusOr<uint64_t> ParseRetention(absl::string_view text);
// Reads LAT,LON,ALT,HEADING; the last two may be left out (0).
absl::StatusOr<v1::GeoOrigin> ParseOrigin(absl::string_view text);

// Makes a request that changes what was given of the mission, as the store has it now, and nothing
// else: limits and labels that were not given stay. INVALID_ARGUMENT, naming the flag, for what
// can't be read, and if nothing was given.
absl::StatusOr<v1::UpdateMissionRequest> MakeUpdate(const MissionSettings& settings,
                                                    const v1::Mission& now);

// Writes what is set of the mission, a line for each, each with an end; empty if nothing is.
std::string FormatSettings(const v1::Mission& mission);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_TOOL_MISSION_MISSION_SETTINGS_H_
