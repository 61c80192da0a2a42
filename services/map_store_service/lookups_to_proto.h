// Converts what the map store answers to the messages of the contract.
#ifndef CORBSLAM_SERVICES_MAP_STORE_SERVICE_LOOKUPS_TO_PROTO_H_
#define CORBSLAM_SERVICES_MAP_STORE_SERVICE_LOOKUPS_TO_PROTO_H_

#include <string>
#include <vector>

#include "absl/strings/string_view.h"
#include "corbslam/v1/overlap.pb.h"
#include "corbslam/v1/resources.pb.h"
#include "map_store/state/lookups.h"

namespace corbslam::services {

void ToProto(const map_store::MissionInfo& info, v1::Mission* proto);
void ToProto(absl::string_view mission, const map_store::AgentInfo& info, v1::MissionAgent* proto);
void ToProto(absl::string_view mission, const map_store::LocalMapInfo& info, v1::LocalMap* proto);
void ToProto(absl::string_view mission, const map_store::KeyframeInfo& info, v1::Keyframe* proto);
void ToProto(absl::string_view mission, const map_store::OverlapInfo& info, v1::Overlap* proto);
void ToProto(absl::string_view mission, const map_store::MissionStatistics& statistics,
             v1::MissionStatistics* proto);
// Groups local maps by their islands, the reference island first.
void AddIslands(absl::string_view mission, const std::vector<map_store::LocalMapInfo>& local_maps,
                v1::MissionStatistics* proto);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_MAP_STORE_SERVICE_LOOKUPS_TO_PROTO_H_
