// Says what a person wants to know of a mission: who is in it, what each made, what was fused, and
// why the rest was not.
#ifndef CORBSLAM_SERVICES_TOOL_MISSION_MISSION_SUMMARY_H_
#define CORBSLAM_SERVICES_TOOL_MISSION_MISSION_SUMMARY_H_

#include <grpcpp/channel.h>

#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "corbslam/v1/map_store_service.grpc.pb.h"

namespace corbslam::services {

struct MissionSummary {
  v1::Mission mission;
  std::vector<v1::MissionAgent> agents;
  std::vector<v1::LocalMap> local_maps;
  std::vector<v1::Overlap> overlaps;
  // Only failed_requests is used, and which local maps are not compared in whole.
  v1::MissionStatistics statistics;
};

// Returns the agents of a mission, by name.
absl::StatusOr<std::vector<v1::MissionAgent>> ReadAgents(
    const std::shared_ptr<grpc::Channel>& channel, const std::string& mission);

// Reads the summary by several calls: what changes in between may be in one and not in the other.
// Errors name the call.
absl::StatusOr<MissionSummary> ReadSummary(const std::shared_ptr<grpc::Channel>& channel,
                                           const std::string& mission);

// Writes tables and sentences. Robots are listed by name, local maps as ROBOT/N for the robot's
// N-th. For every two local maps of different robots it says what became of the overlaps between
// them, that there was none, or that nobody has looked yet, and why.
std::string FormatSummary(const MissionSummary& summary);
nlohmann::ordered_json ToJson(const MissionSummary& summary);

// Writes a table with a line for each mission.
std::string FormatMissions(const std::vector<v1::Mission>& missions);

// Returns "idle", "busy", "waits for a worker" or "has no worker".
std::string DescribeFusion(const v1::Mission& mission);

// Returns text such as "too few keypoints look alike".
std::string DescribeVerdict(v1::OverlapVerdict verdict);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_TOOL_MISSION_MISSION_SUMMARY_H_
