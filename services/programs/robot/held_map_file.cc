#include "services/programs/robot/held_map_file.h"

#include <fstream>
#include <iterator>
#include <limits>
#include <utility>

#include "absl/strings/str_cat.h"
#include "services/agent_service/near_map_message.h"
#include "slam/util/atomic_file.h"

namespace corbslam::services {

using client_agent::Agent;
using client_agent::NearMap;
using client_agent::NearMapLimits;

std::optional<NearMap> GetHeldMap(const Agent& agent) {
  NearMapLimits limits;
  limits.radius_m = std::numeric_limits<double>::infinity();
  limits.max_points = 1'000'000;
  limits.max_keyframes = 100'000;
  return agent.GetNearMap(limits);
}

absl::Status WriteHeldMap(const std::optional<NearMap>& held, const std::string& path) {
  std::string bytes;
  if (held.has_value()) {
    v1::WatchAgentMapResponse proto;
    ToProto(*held, &proto);
    bytes = proto.SerializeAsString();
  }
  return WriteAtomically(path, bytes);
}

absl::StatusOr<std::optional<NearMap>> ReadHeldMap(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) return absl::NotFoundError(absl::StrCat("there is no ", path));
  const std::string bytes((std::istreambuf_iterator<char>(file)), {});
  if (bytes.empty()) return std::nullopt;
  v1::WatchAgentMapResponse proto;
  if (!proto.ParseFromString(bytes)) {
    return absl::DataLossError(absl::StrCat(path, " is not what a robot writes of its map"));
  }
  absl::StatusOr<NearMap> held = FromProto(proto);
  if (held.ok()) return *std::move(held);
  return absl::DataLossError(absl::StrCat(path, ": ", held.status().message()));
}

}  // namespace corbslam::services
