#include "services/convert/resource_names.h"
#include "services/map_store_service/lookups_to_proto.h"
#include "services/map_store_service/map_store_service.h"
#include "services/map_store_service/paging.h"
#include "services/server/process_usage.h"
#include "services/server/unary.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {

using map_store::AgentInfo;
using map_store::LocalMapInfo;
using map_store::MissionStatistics;
using map_store::PageRequest;

grpc::ServerUnaryReactor* MapStoreService::GetStatistics(grpc::CallbackServerContext* context,
                                                         const v1::GetStatisticsRequest* request,
                                                         v1::GetStatisticsResponse* response) {
  return AnswerOn(pool_, context, [this, request, response]() -> absl::Status {
    ASSIGN_OR_RETURN(const std::string mission, ParseMissionName(request->mission()));
    ASSIGN_OR_RETURN(const MissionStatistics statistics, store_.GetStatistics(mission));
    v1::MissionStatistics* proto = response->mutable_mission();
    ToProto(mission, statistics, proto);
    ASSIGN_OR_RETURN(const auto local_maps,
                     ReadAllPages<LocalMapInfo>([&](const PageRequest& page) {
                       return store_.ListLocalMaps(mission, page);
                     }));
    AddIslands(mission, local_maps, proto);
    ASSIGN_OR_RETURN(const auto agents, ReadAllPages<AgentInfo>([&](const PageRequest& page) {
                       return store_.ListAgents(mission, page);
                     }));
    for (const AgentInfo& agent : agents) {
      if (agent.connected) proto->set_connected_agents(proto->connected_agents() + 1);
    }
    ASSIGN_OR_RETURN(const bool idle, store_.IsFusionIdle(mission));
    proto->set_fusion_idle(idle);
    const ProcessUsage usage = GetProcessUsage();
    response->mutable_server()->set_peak_rss_bytes(usage.peak_rss_bytes);
    response->mutable_server()->set_cpu_s(usage.cpu_s);
    return absl::OkStatus();
  });
}

}  // namespace corbslam::services
