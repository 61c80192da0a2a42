// Makes and parses names of the resource style, as proto/corbslam/v1/resources.proto says.
#ifndef CORBSLAM_SERVICES_CONVERT_RESOURCE_NAMES_H_
#define CORBSLAM_SERVICES_CONVERT_RESOURCE_NAMES_H_

#include <cstdint>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "slam/util/ids.h"

namespace corbslam::services {

// The parent of what all missions have.
inline constexpr absl::string_view kAllMissions = "missions/-";

std::string MissionName(absl::string_view mission);
std::string AgentName(absl::string_view mission, absl::string_view agent);
std::string LocalMapName(absl::string_view mission, LocalMapId local_map);
std::string KeyframeName(absl::string_view mission, KeyframeId keyframe);
std::string OverlapName(absl::string_view mission, uint64_t overlap);
std::string BackupName(absl::string_view mission, uint32_t number);

// Returns "alpha" of "missions/lab/agents/alpha"; the whole name where it has no slash.
std::string LastSegment(const std::string& name);

struct AgentPath {
  std::string mission;
  std::string agent;  // Empty for "-", which means all agents.
};
struct LocalMapPath {
  std::string mission;
  LocalMapId local_map;  // Invalid for "-", which means all local maps.
};
struct KeyframePath {
  std::string mission;
  KeyframeId keyframe;
};
struct OverlapPath {
  std::string mission;
  uint64_t overlap = 0;
};

struct BackupPath {
  std::string mission;
  uint32_t number = 0;
};

// INVALID_ARGUMENT names what was given and the form that is wanted.
absl::Status CheckNameSegment(absl::string_view field, absl::string_view segment);
absl::StatusOr<std::string> ParseMissionName(absl::string_view name);
absl::StatusOr<AgentPath> ParseAgentName(absl::string_view name, bool may_be_all);
absl::StatusOr<LocalMapPath> ParseLocalMapName(absl::string_view name, bool may_be_all);
absl::StatusOr<KeyframePath> ParseKeyframeName(absl::string_view name);
absl::StatusOr<OverlapPath> ParseOverlapName(absl::string_view name);
absl::StatusOr<BackupPath> ParseBackupName(absl::string_view name);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_CONVERT_RESOURCE_NAMES_H_
