// What people set of a mission, and when it was made and used.
#ifndef CORBSLAM_MAP_STORE_STATE_MISSION_PROFILE_H_
#define CORBSLAM_MAP_STORE_STATE_MISSION_PROFILE_H_

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/time/time.h"

namespace corbslam::map_store {

// Where the origin of a mission's global frame lies on Earth (WGS 84).
struct GeoOrigin {
  double latitude_deg = 0;
  double longitude_deg = 0;
  double altitude_m = 0;   // Above the ellipsoid.
  double heading_deg = 0;  // Of the frame's x axis, clockwise from true north.
  friend bool operator==(const GeoOrigin&, const GeoOrigin&) = default;
};

// What is taken in at most; 0: as much as the store takes of any mission or agent.
struct MissionLimits {
  uint64_t keyframes = 0;
  uint64_t memory_bytes = 0;  // Of a mission only, as the next one.
  uint64_t disk_bytes = 0;
  uint64_t uplink_bytes_per_second = 0;  // Of each agent.
  friend bool operator==(const MissionLimits&, const MissionLimits&) = default;
};

// Settings of robots as an owner of the mission signed them (docs/robot.md). The store hands them
// on and can't make any.
struct SignedSettings {
  uint64_t version = 0;  // As it stands in `bytes`; 0: these are none.
  std::string bytes;     // A RobotSettings of the contract, as it was signed.
  std::string signature;
  friend bool operator==(const SignedSettings&, const SignedSettings&) = default;
};

struct MissionProfile {
  std::string description;
  std::map<std::string, std::string> labels;
  MissionLimits limits;
  std::map<std::string, MissionLimits> agent_limits;  // By the agent's name.
  // The mission is deleted once nobody has used it for so long; 0: never.
  uint64_t retention_s = 0;
  std::optional<GeoOrigin> origin;
  // Nanoseconds since 1970 by the store's clock; 0: not known.
  int64_t created_ns = 0;
  int64_t last_used_ns = 0;
  // Grows by one with each change of the fields above that people make.
  uint64_t revision = 0;
  // By the agent's name; under the empty one those of all the mission's robots.
  std::map<std::string, SignedSettings> robot_settings = {};
  friend bool operator==(const MissionProfile&, const MissionProfile&) = default;
};

// Versions of settings of robots that an agent was told; 0: of none.
struct SettingsVersions {
  uint64_t of_all = 0;
  uint64_t of_agent = 0;
  friend bool operator==(const SettingsVersions&, const SettingsVersions&) = default;
};

// What can be changed of a profile.
enum class ProfileField { kDescription, kLabels, kLimits, kAgentLimits, kRetention, kOrigin };

inline constexpr size_t kMaxDescriptionBytes = 1000;
inline constexpr size_t kMaxLabels = 64;
inline constexpr size_t kMaxLabelValueBytes = 255;
inline constexpr size_t kMaxAgentLimits = 1000;
inline constexpr size_t kMaxSettingsBytes = 64 << 10;
// All settings of a mission's robots have so many bytes at most; they travel with the mission's
// summary.
inline constexpr size_t kMaxAllSettingsBytes = 1 << 20;
inline constexpr size_t kSignatureBytes = 64;
// An agent that may send less than this a second would not get one keyframe up in a minute.
inline constexpr uint64_t kLeastUplinkBytesPerSecond = 1000;

// Returns INVALID_ARGUMENT, with the field, its value and its bound, for a profile that is none.
absl::Status ValidateProfile(const MissionProfile& profile);

// Puts these fields of `values`, each as a whole, into the profile.
void PutFields(const MissionProfile& values, const std::vector<ProfileField>& fields,
               MissionProfile& profile);

// Puts the settings of one agent, or under the empty name those of all, into the profile.
// INVALID_ARGUMENT for what is out of its bounds; FAILED_PRECONDITION if the profile has the same
// or a newer version.
absl::Status PutSettings(const std::string& agent, const SignedSettings& settings,
                         MissionProfile& profile);

// Returns how fast the agent may send: its own limit, or else the mission's; 0: as fast as it can.
uint64_t UplinkLimit(const MissionProfile& profile, const std::string& agent);

// Returns the time as a profile has it; 0 for one before 1970.
int64_t ToProfileTime(absl::Time time);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_STATE_MISSION_PROFILE_H_
