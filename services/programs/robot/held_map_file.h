// A file of what a robot holds in the end of the map: its own part and what others made. corbslam
// run draws its pictures of robots' maps from such files.
#ifndef CORBSLAM_SERVICES_PROGRAMS_ROBOT_HELD_MAP_FILE_H_
#define CORBSLAM_SERVICES_PROGRAMS_ROBOT_HELD_MAP_FILE_H_

#include <optional>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "client_agent/agent/agent.h"
#include "client_agent/map/near_map.h"

namespace corbslam::services {

// Returns all that the local map in use holds, up to a million points and 100,000 keyframes (the
// nearest to the newest pose; `truncated` says whether there are more); nullopt as long as no frame
// had a pose.
std::optional<client_agent::NearMap> GetHeldMap(const client_agent::Agent& agent);

// Writes a v1.WatchAgentMapResponse in protobuf's binary form; an empty file for nullopt.
// UNAVAILABLE names the file.
absl::Status WriteHeldMap(const std::optional<client_agent::NearMap>& held,
                          const std::string& path);
// NOT_FOUND if there is no such file, DATA_LOSS with the reason if it is none of this form.
absl::StatusOr<std::optional<client_agent::NearMap>> ReadHeldMap(const std::string& path);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_PROGRAMS_ROBOT_HELD_MAP_FILE_H_
