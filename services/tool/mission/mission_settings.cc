#include "services/tool/mission/mission_settings.h"

#include <cmath>
#include <limits>
#include <map>

#include "absl/strings/escaping.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_split.h"
#include "absl/time/time.h"
#include "services/convert/limits.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {
namespace {

constexpr uint64_t kDay_s = 86400;

absl::Status BadFlag(absl::string_view flag, absl::string_view given, absl::string_view wanted) {
  return absl::InvalidArgumentError(
      absl::StrCat(flag, " is \"", absl::CHexEscape(given.substr(0, 80)), "\", must be ", wanted));
}

// Returns an error where the bytes would be more than a number holds.
absl::StatusOr<uint64_t> ToBytes(absl::string_view flag, uint64_t mebibytes) {
  constexpr uint64_t kMost = std::numeric_limits<uint64_t>::max() >> 20;
  if (mebibytes <= kMost) return mebibytes << 20;
  return BadFlag(flag, absl::StrCat(mebibytes), absl::StrCat("at most ", kMost, " MiB"));
}

// Returns bytes a second.
absl::StatusOr<uint64_t> ToRate(uint64_t kbps) {
  if (kLink_kbps.Contains(static_cast<double>(kbps))) return kbps * 1000 / 8;
  return BadFlag("--uplink-kbps", absl::StrCat(kbps), DescribeRange(kLink_kbps, true));
}

absl::Status PutLimits(const MissionSettings& settings, v1::MissionLimits& limits) {
  if (settings.max_keyframes) limits.set_keyframes(*settings.max_keyframes);
  if (settings.uplink_kbps) {
    ASSIGN_OR_RETURN(const uint64_t rate, ToRate(*settings.uplink_kbps));
    limits.set_uplink_bytes_per_second(rate);
  }
  if (settings.max_memory_mb) {
    ASSIGN_OR_RETURN(const uint64_t bytes, ToBytes("--max-memory-mb", *settings.max_memory_mb));
    limits.set_memory_bytes(bytes);
  }
  if (settings.max_disk_mb) {
    ASSIGN_OR_RETURN(const uint64_t bytes, ToBytes("--max-disk-mb", *settings.max_disk_mb));
    limits.set_disk_bytes(bytes);
  }
  return absl::OkStatus();
}

bool IsUnlimited(const v1::MissionLimits& limits) {
  return limits.keyframes() == 0 && limits.memory_bytes() == 0 && limits.disk_bytes() == 0 &&
         limits.uplink_bytes_per_second() == 0;
}

absl::Status ChangeLimits(const MissionSettings& settings, v1::UpdateMissionRequest& request) {
  const bool has_any = settings.max_keyframes || settings.max_memory_mb || settings.max_disk_mb ||
                       settings.uplink_kbps;
  v1::Mission& mission = *request.mutable_mission();
  if (settings.agent.empty()) {
    if (!has_any) return absl::OkStatus();
    request.mutable_update_mask()->add_paths("limits");
    return PutLimits(settings, *mission.mutable_limits());
  }
  if (!has_any || settings.max_memory_mb || settings.max_disk_mb) {
    return absl::InvalidArgumentError(
        absl::StrCat("--agent ", settings.agent,
                     " takes --max-keyframes and --uplink-kbps, at least one of them; the limits "
                     "of memory and disk are whole missions'"));
  }
  request.mutable_update_mask()->add_paths("agent_limits");
  v1::MissionLimits& limits = (*mission.mutable_agent_limits())[settings.agent];
  RETURN_IF_ERROR(PutLimits(settings, limits));
  if (IsUnlimited(limits)) mission.mutable_agent_limits()->erase(settings.agent);
  return absl::OkStatus();
}

absl::Status ChangeLabels(const MissionSettings& settings, v1::UpdateMissionRequest& request) {
  if (settings.labels.empty() && settings.remove_labels.empty()) return absl::OkStatus();
  auto& labels = *request.mutable_mission()->mutable_labels();
  for (const std::string& key : settings.remove_labels) {
    if (labels.erase(key) == 0) return BadFlag("--remove-label", key, "a label that is there");
  }
  for (const std::string& label : settings.labels) {
    const std::pair<std::string, std::string> parts =
        absl::StrSplit(label, absl::MaxSplits('=', 1));
    if (label.find('=') == std::string::npos) return BadFlag("--label", label, "KEY=VALUE");
    labels[parts.first] = parts.second;
  }
  request.mutable_update_mask()->add_paths("labels");
  return absl::OkStatus();
}

// Returns "30 d", "36 h" or "90 s", whatever is whole.
std::string DescribeSeconds(uint64_t seconds) {
  if (seconds % kDay_s == 0) return absl::StrCat(seconds / kDay_s, " d");
  if (seconds % 3600 == 0) return absl::StrCat(seconds / 3600, " h");
  return absl::StrCat(seconds, " s");
}

std::string DescribeLimits(const v1::MissionLimits& limits) {
  std::vector<std::string> parts;
  const auto mib = [](uint64_t bytes) {
    return absl::StrFormat("%.6g MiB", static_cast<double>(bytes) / (1 << 20));
  };
  if (limits.keyframes() > 0) parts.push_back(absl::StrCat(limits.keyframes(), " keyframes"));
  if (limits.memory_bytes() > 0) parts.push_back(mib(limits.memory_bytes()) + " of memory");
  if (limits.disk_bytes() > 0) parts.push_back(mib(limits.disk_bytes()) + " of disk");
  if (limits.uplink_bytes_per_second() > 0) {
    parts.push_back(absl::StrFormat("%.6g kbit/s a robot",
                                    8e-3 * static_cast<double>(limits.uplink_bytes_per_second())));
  }
  return absl::StrJoin(parts, ", ");
}

std::string DescribeTime(int64_t time_ns) {
  return absl::FormatTime("%Y-%m-%d %H:%M:%S", absl::FromUnixNanos(time_ns), absl::LocalTimeZone());
}

// What others wrote must not drive the terminal.
std::string Harmless(const std::string& text) { return absl::Utf8SafeCEscape(text); }

}  // namespace

bool IsEmpty(const MissionSettings& settings) {
  const bool has_limit = settings.max_keyframes || settings.max_memory_mb || settings.max_disk_mb ||
                         settings.uplink_kbps || !settings.agent.empty();
  return !has_limit && !settings.description && settings.labels.empty() &&
         settings.remove_labels.empty() && !settings.retention && !settings.origin;
}

absl::StatusOr<uint64_t> ParseRetention(absl::string_view text) {
  if (text == "never" || text == "0") return 0;
  constexpr char kWanted[] = "such as 30d, 12h, 90m or 45s, or never";
  static const auto& units =
      *new std::map<char, uint64_t>{{'d', kDay_s}, {'h', 3600}, {'m', 60}, {'s', 1}};
  const auto unit = units.find(text.empty() ? '\0' : text.back());
  uint64_t number = 0;
  if (unit == units.end() || !absl::SimpleAtoi(text.substr(0, text.size() - 1), &number) ||
      number == 0 || number > 100 * 366 * kDay_s / unit->second) {
    return BadFlag("--retention", text, absl::StrCat(kWanted, ", and at most a hundred years"));
  }
  return number * unit->second;
}

absl::StatusOr<v1::GeoOrigin> ParseOrigin(absl::string_view text) {
  std::vector<double> numbers;
  for (const absl::string_view part : absl::StrSplit(text, ',')) {
    if (!absl::SimpleAtod(part, &numbers.emplace_back()) || !std::isfinite(numbers.back())) {
      numbers.clear();
      break;
    }
  }
  if (numbers.size() < 2 || numbers.size() > 4) {
    return BadFlag("--origin", text,
                   "LATITUDE,LONGITUDE[,ALTITUDE[,HEADING]] in degrees, degrees, metres, degrees");
  }
  numbers.resize(4);
  v1::GeoOrigin origin;
  origin.set_latitude_deg(numbers[0]);
  origin.set_longitude_deg(numbers[1]);
  origin.set_altitude_m(numbers[2]);
  origin.set_heading_deg(numbers[3]);
  return origin;
}

absl::StatusOr<v1::UpdateMissionRequest> MakeUpdate(const MissionSettings& settings,
                                                    const v1::Mission& now) {
  if (IsEmpty(settings)) {
    return absl::InvalidArgumentError("nothing is to be changed: give a flag, see --help");
  }
  v1::UpdateMissionRequest request;
  *request.mutable_mission() = now;
  google::protobuf::FieldMask& mask = *request.mutable_update_mask();
  if (settings.description) {
    request.mutable_mission()->set_description(*settings.description);
    mask.add_paths("description");
  }
  RETURN_IF_ERROR(ChangeLabels(settings, request));
  RETURN_IF_ERROR(ChangeLimits(settings, request));
  if (settings.retention) {
    ASSIGN_OR_RETURN(const uint64_t retention_s, ParseRetention(*settings.retention));
    request.mutable_mission()->set_retention_s(retention_s);
    mask.add_paths("retention_s");
  }
  if (settings.origin) {
    request.mutable_mission()->clear_origin();
    if (*settings.origin != "none") {
      ASSIGN_OR_RETURN(*request.mutable_mission()->mutable_origin(), ParseOrigin(*settings.origin));
    }
    mask.add_paths("origin");
  }
  return request;
}

std::string FormatSettings(const v1::Mission& mission) {
  std::string text;
  const auto line = [&text](absl::string_view name, const std::string& value) {
    if (!value.empty()) absl::StrAppend(&text, name, ": ", value, "\n");
  };
  line("Description", Harmless(mission.description()));
  // A protobuf map has no order.
  const std::map<std::string, std::string> labels(mission.labels().begin(), mission.labels().end());
  for (const auto& [key, value] : labels) line("Label", absl::StrCat(key, "=", Harmless(value)));
  line("Limits", DescribeLimits(mission.limits()));
  const std::map<std::string, v1::MissionLimits> agents(mission.agent_limits().begin(),
                                                        mission.agent_limits().end());
  for (const auto& [agent, limits] : agents) {
    line(absl::StrCat("Limits of ", agent), DescribeLimits(limits));
  }
  if (mission.retention_s() > 0) {
    line("Retention",
         absl::StrCat("deleted once unused for ", DescribeSeconds(mission.retention_s())));
  }
  if (mission.has_origin()) {
    const v1::GeoOrigin& origin = mission.origin();
    line("Origin", absl::StrFormat("%.9g, %.9g, %.3f m, x axis %.6g degrees from north",
                                   origin.latitude_deg(), origin.longitude_deg(),
                                   origin.altitude_m(), origin.heading_deg()));
  }
  if (mission.created_ns() > 0) line("Created", DescribeTime(mission.created_ns()));
  if (mission.last_used_ns() > 0) line("Last used", DescribeTime(mission.last_used_ns()));
  return text;
}

}  // namespace corbslam::services
