#include "map_store/state/mission_profile.h"

#include <algorithm>
#include <cmath>

#include "absl/strings/ascii.h"
#include "absl/strings/escaping.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "slam/util/status_macros.h"

namespace corbslam::map_store {
namespace {

// Nobody lives farther from the ellipsoid, in metres.
constexpr double kMaxAltitude_m = 1e7;

// Returns what somebody gave, so that it can stand in a message.
std::string Shown(absl::string_view given) {
  return absl::CHexEscape(given.substr(0, std::min<size_t>(given.size(), 80)));
}

absl::Status CheckAtMost(absl::string_view field, size_t value, size_t most,
                         absl::string_view unit) {
  if (value <= most) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrCat(field, " has ", value, " ", unit, ", must have at most ", most));
}

bool IsWord(absl::string_view word) {
  return !word.empty() && word.size() <= 63 && std::ranges::all_of(word, [](char c) {
    return absl::ascii_isalnum(static_cast<unsigned char>(c)) || c == '.' || c == '-' || c == '_';
  });
}

absl::Status CheckLabels(const std::map<std::string, std::string>& labels) {
  RETURN_IF_ERROR(CheckAtMost("labels", labels.size(), kMaxLabels, "labels"));
  for (const auto& [key, value] : labels) {
    if (!IsWord(key)) {
      return absl::InvalidArgumentError(
          absl::StrCat("labels has the key \"", Shown(key),
                       "\", must be 1 to 63 letters, digits, dots, dashes and underscores"));
    }
    RETURN_IF_ERROR(
        CheckAtMost(absl::StrCat("labels[", key, "]"), value.size(), kMaxLabelValueBytes, "bytes"));
  }
  return absl::OkStatus();
}

absl::Status CheckLimits(absl::string_view field, const MissionLimits& limits) {
  const uint64_t uplink = limits.uplink_bytes_per_second;
  if (uplink == 0 || uplink >= kLeastUplinkBytesPerSecond) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrCat(field, ".uplink_bytes_per_second is ", uplink,
                                                 ", must be 0 (no limit) or at least ",
                                                 kLeastUplinkBytesPerSecond));
}

absl::Status CheckAgentLimits(const std::map<std::string, MissionLimits>& agents) {
  RETURN_IF_ERROR(CheckAtMost("agent_limits", agents.size(), kMaxAgentLimits, "agents"));
  for (const auto& [name, limits] : agents) {
    if (!IsWord(name) || !absl::ascii_isalnum(static_cast<unsigned char>(name[0]))) {
      return absl::InvalidArgumentError(
          absl::StrCat("agent_limits has the agent \"", Shown(name),
                       "\", must be 1 to 63 letters, digits, dots, dashes and underscores, and "
                       "begin with a letter or digit"));
    }
    const std::string field = absl::StrCat("agent_limits[", name, "]");
    if (limits.memory_bytes != 0 || limits.disk_bytes != 0) {
      return absl::InvalidArgumentError(
          absl::StrCat(field, ".memory_bytes is ", limits.memory_bytes, " and .disk_bytes ",
                       limits.disk_bytes, ", must be 0: only whole missions have these limits"));
    }
    RETURN_IF_ERROR(CheckLimits(field, limits));
  }
  return absl::OkStatus();
}

// Returns an error also for a value that is no number.
absl::Status CheckRange(absl::string_view field, double value, double least, double most) {
  if (value >= least && value <= most) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrCat("origin.", field, " is ", value, ", must be ", least, " to ", most));
}

absl::Status CheckOrigin(const GeoOrigin& origin) {
  RETURN_IF_ERROR(CheckRange("latitude_deg", origin.latitude_deg, -90, 90));
  RETURN_IF_ERROR(CheckRange("longitude_deg", origin.longitude_deg, -180, 180));
  RETURN_IF_ERROR(CheckRange("altitude_m", origin.altitude_m, -kMaxAltitude_m, kMaxAltitude_m));
  return CheckRange("heading_deg", origin.heading_deg, 0, 360);
}

absl::Status CheckTime(absl::string_view field, int64_t time_ns) {
  if (time_ns >= 0) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrCat(field, " is ", time_ns, ", must be at least 0"));
}

// Returns "the settings of robot NAME", or of all.
std::string SettingsOf(const std::string& agent) {
  if (agent.empty()) return "the settings of all robots";
  return absl::StrCat("the settings of robot ", Shown(agent));
}

absl::Status CheckSettings(const std::string& agent, const SignedSettings& settings) {
  const bool is_agent = IsWord(agent) && absl::ascii_isalnum(static_cast<unsigned char>(agent[0]));
  if (!agent.empty() && !is_agent) {
    return absl::InvalidArgumentError(
        absl::StrCat(SettingsOf(agent),
                     " are for a name that no robot can have: 1 to 63 letters, digits, dots, "
                     "dashes and underscores, the first a letter or digit"));
  }
  if (settings.version == 0 || settings.signature.size() != kSignatureBytes) {
    return absl::InvalidArgumentError(
        absl::StrCat(SettingsOf(agent), " have version ", settings.version, " and a signature of ",
                     settings.signature.size(), " bytes, must have at least version 1 and ",
                     kSignatureBytes, " bytes"));
  }
  return CheckAtMost(SettingsOf(agent), settings.bytes.size(), kMaxSettingsBytes, "bytes");
}

absl::Status CheckAllSettings(const std::map<std::string, SignedSettings>& all) {
  size_t bytes = 0;
  for (const auto& [agent, settings] : all) {
    RETURN_IF_ERROR(CheckSettings(agent, settings));
    bytes += agent.size() + settings.bytes.size();
  }
  RETURN_IF_ERROR(CheckAtMost("robot_settings", all.size(), kMaxAgentLimits + 1, "entries"));
  return CheckAtMost("robot_settings", bytes, kMaxAllSettingsBytes, "bytes, of all robots,");
}

}  // namespace

absl::Status ValidateProfile(const MissionProfile& profile) {
  RETURN_IF_ERROR(
      CheckAtMost("description", profile.description.size(), kMaxDescriptionBytes, "bytes"));
  RETURN_IF_ERROR(CheckLabels(profile.labels));
  RETURN_IF_ERROR(CheckLimits("limits", profile.limits));
  RETURN_IF_ERROR(CheckAgentLimits(profile.agent_limits));
  if (profile.origin.has_value()) RETURN_IF_ERROR(CheckOrigin(*profile.origin));
  RETURN_IF_ERROR(CheckAllSettings(profile.robot_settings));
  RETURN_IF_ERROR(CheckTime("created_ns", profile.created_ns));
  return CheckTime("last_used_ns", profile.last_used_ns);
}

void PutFields(const MissionProfile& values, const std::vector<ProfileField>& fields,
               MissionProfile& profile) {
  for (const ProfileField field : fields) {
    switch (field) {
      case ProfileField::kDescription:
        profile.description = values.description;
        break;
      case ProfileField::kLabels:
        profile.labels = values.labels;
        break;
      case ProfileField::kLimits:
        profile.limits = values.limits;
        break;
      case ProfileField::kAgentLimits:
        profile.agent_limits = values.agent_limits;
        break;
      case ProfileField::kRetention:
        profile.retention_s = values.retention_s;
        break;
      case ProfileField::kOrigin:
        profile.origin = values.origin;
        break;
    }
  }
}

absl::Status PutSettings(const std::string& agent, const SignedSettings& settings,
                         MissionProfile& profile) {
  RETURN_IF_ERROR(CheckSettings(agent, settings));
  const auto before = profile.robot_settings.find(agent);
  if (before != profile.robot_settings.end() && settings.version <= before->second.version) {
    return absl::FailedPreconditionError(absl::StrCat(
        SettingsOf(agent), " have version ", settings.version, ", must be newer than version ",
        before->second.version, ", which the map store has: read those, and sign anew"));
  }
  profile.robot_settings[agent] = settings;
  return absl::OkStatus();
}

uint64_t UplinkLimit(const MissionProfile& profile, const std::string& agent) {
  const auto own = profile.agent_limits.find(agent);
  if (own != profile.agent_limits.end() && own->second.uplink_bytes_per_second > 0) {
    return own->second.uplink_bytes_per_second;
  }
  return profile.limits.uplink_bytes_per_second;
}

int64_t ToProfileTime(absl::Time time) { return std::max<int64_t>(0, absl::ToUnixNanos(time)); }

}  // namespace corbslam::map_store
