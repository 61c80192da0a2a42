#include "services/map_store_service/profile_convert.h"

#include <map>
#include <string>
#include <utility>

#include "absl/strings/escaping.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {

using map_store::GeoOrigin;
using map_store::MissionLimits;
using map_store::MissionProfile;
using map_store::ProfileField;

namespace {

void ToProto(const MissionLimits& limits, v1::MissionLimits* proto) {
  proto->set_keyframes(limits.keyframes);
  proto->set_memory_bytes(limits.memory_bytes);
  proto->set_disk_bytes(limits.disk_bytes);
  proto->set_uplink_bytes_per_second(limits.uplink_bytes_per_second);
}

MissionLimits FromProto(const v1::MissionLimits& proto) {
  return {.keyframes = proto.keyframes(),
          .memory_bytes = proto.memory_bytes(),
          .disk_bytes = proto.disk_bytes(),
          .uplink_bytes_per_second = proto.uplink_bytes_per_second()};
}

const std::map<absl::string_view, ProfileField>& Paths() {
  static const auto& paths = *new std::map<absl::string_view, ProfileField>{
      {"description", ProfileField::kDescription}, {"labels", ProfileField::kLabels},
      {"limits", ProfileField::kLimits},           {"agent_limits", ProfileField::kAgentLimits},
      {"retention_s", ProfileField::kRetention},   {"origin", ProfileField::kOrigin}};
  return paths;
}

// Nothing that a store has is so many.
constexpr uint64_t kMostAsked = uint64_t{1} << 50;
constexpr uint64_t kLongestRetention_s = uint64_t{100} * 366 * 86'400;

absl::Status CheckAskedAtMost(absl::string_view field, uint64_t value, uint64_t most) {
  if (value <= most) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrCat(field, " is ", value, ", must be at most ", most, ": was it negative?"));
}

absl::Status CheckAsked(absl::string_view field, const v1::MissionLimits& limits) {
  for (const auto& [name, value] :
       {std::pair("keyframes", limits.keyframes()),
        std::pair("memory_bytes", limits.memory_bytes()),
        std::pair("disk_bytes", limits.disk_bytes()),
        std::pair("uplink_bytes_per_second", limits.uplink_bytes_per_second())}) {
    RETURN_IF_ERROR(CheckAskedAtMost(absl::StrCat(field, ".", name), value, kMostAsked));
  }
  return absl::OkStatus();
}

}  // namespace

void ToProto(const MissionProfile& profile, v1::Mission* proto) {
  proto->set_description(profile.description);
  proto->mutable_labels()->insert(profile.labels.begin(), profile.labels.end());
  if (profile.limits != MissionLimits()) ToProto(profile.limits, proto->mutable_limits());
  for (const auto& [agent, limits] : profile.agent_limits) {
    ToProto(limits, &(*proto->mutable_agent_limits())[agent]);
  }
  proto->set_retention_s(profile.retention_s);
  proto->set_settings_revision(profile.revision);
  proto->set_created_ns(profile.created_ns);
  proto->set_last_used_ns(profile.last_used_ns);
  if (!profile.origin.has_value()) return;
  v1::GeoOrigin& origin = *proto->mutable_origin();
  origin.set_latitude_deg(profile.origin->latitude_deg);
  origin.set_longitude_deg(profile.origin->longitude_deg);
  origin.set_altitude_m(profile.origin->altitude_m);
  origin.set_heading_deg(profile.origin->heading_deg);
}

MissionProfile ProfileFromProto(const v1::Mission& proto) {
  MissionProfile profile;
  profile.description = proto.description();
  profile.labels.insert(proto.labels().begin(), proto.labels().end());
  profile.limits = FromProto(proto.limits());
  for (const auto& [agent, limits] : proto.agent_limits()) {
    profile.agent_limits[agent] = FromProto(limits);
  }
  profile.retention_s = proto.retention_s();
  if (!proto.has_origin()) return profile;
  profile.origin = GeoOrigin{.latitude_deg = proto.origin().latitude_deg(),
                             .longitude_deg = proto.origin().longitude_deg(),
                             .altitude_m = proto.origin().altitude_m(),
                             .heading_deg = proto.origin().heading_deg()};
  return profile;
}

absl::Status CheckAskedLimits(const v1::Mission& proto, const std::vector<ProfileField>& fields) {
  for (const ProfileField field : fields) {
    if (field == ProfileField::kLimits) {
      RETURN_IF_ERROR(CheckAsked("limits", proto.limits()));
    } else if (field == ProfileField::kAgentLimits) {
      for (const auto& [agent, limits] : proto.agent_limits()) {
        RETURN_IF_ERROR(CheckAsked(
            absl::StrCat("agent_limits[", absl::CHexEscape(agent.substr(0, 80)), "]"), limits));
      }
    } else if (field == ProfileField::kRetention) {
      RETURN_IF_ERROR(CheckAskedAtMost("retention_s", proto.retention_s(), kLongestRetention_s));
    }
  }
  return absl::OkStatus();
}

absl::StatusOr<std::vector<ProfileField>> FieldsFromProto(const google::protobuf::FieldMask& mask) {
  constexpr char kWanted[] =
      "must name some of description, labels, limits, agent_limits, retention_s and origin";
  if (mask.paths().empty()) {
    return absl::InvalidArgumentError(absl::StrCat("update_mask is empty, ", kWanted));
  }
  std::vector<ProfileField> fields;
  for (const std::string& path : mask.paths()) {
    const auto field = Paths().find(path);
    if (field == Paths().end()) {
      return absl::InvalidArgumentError(absl::StrCat(
          "update_mask has \"", absl::CHexEscape(path.substr(0, 80)), "\", ", kWanted));
    }
    fields.push_back(field->second);
  }
  return fields;
}

}  // namespace corbslam::services
