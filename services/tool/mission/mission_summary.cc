#include "services/tool/mission/mission_summary.h"

#include <utility>

#include "services/client/store/call_status.h"
#include "services/convert/resource_names.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {
namespace {

// Calls `list(context, request, response)` until the last page, and gives each page to `take`.
template <typename Request, typename Response, typename List, typename Take>
absl::Status ReadPages(const std::string& parent, const char* call, const List& list,
                       const Take& take) {
  Request request;
  request.set_parent(parent);
  do {
    grpc::ClientContext context;
    SetDeadline(context);
    Response response;
    RETURN_IF_ERROR(ToStatus(list(&context, request, &response), call));
    take(response);
    request.set_page_token(response.next_page_token());
  } while (!request.page_token().empty());
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<std::vector<v1::MissionAgent>> ReadAgents(
    const std::shared_ptr<grpc::Channel>& channel, const std::string& mission) {
  const auto stub = v1::MapStore::NewStub(channel);
  std::vector<v1::MissionAgent> agents;
  RETURN_IF_ERROR((ReadPages<v1::ListAgentsRequest, v1::ListAgentsResponse>(
      MissionName(mission), "ListAgents",
      [&](const auto&... arguments) { return stub->ListAgents(arguments...); },
      [&](const v1::ListAgentsResponse& page) {
        agents.insert(agents.end(), page.agents().begin(), page.agents().end());
      })));
  return agents;
}

absl::StatusOr<MissionSummary> ReadSummary(const std::shared_ptr<grpc::Channel>& channel,
                                           const std::string& mission) {
  const auto stub = v1::MapStore::NewStub(channel);
  const std::string name = MissionName(mission);
  MissionSummary summary;
  grpc::ClientContext context;
  SetDeadline(context);
  v1::GetMissionRequest request;
  request.set_name(name);
  RETURN_IF_ERROR(ToStatus(stub->GetMission(&context, request, &summary.mission), "GetMission"));
  ASSIGN_OR_RETURN(summary.agents, ReadAgents(channel, mission));
  RETURN_IF_ERROR((ReadPages<v1::ListLocalMapsRequest, v1::ListLocalMapsResponse>(
      name, "ListLocalMaps",
      [&](const auto&... arguments) { return stub->ListLocalMaps(arguments...); },
      [&](const v1::ListLocalMapsResponse& page) {
        summary.local_maps.insert(summary.local_maps.end(), page.local_maps().begin(),
                                  page.local_maps().end());
      })));
  RETURN_IF_ERROR((ReadPages<v1::ListOverlapsRequest, v1::ListOverlapsResponse>(
      name, "ListOverlaps",
      [&](const auto&... arguments) { return stub->ListOverlaps(arguments...); },
      [&](const v1::ListOverlapsResponse& page) {
        summary.overlaps.insert(summary.overlaps.end(), page.overlaps().begin(),
                                page.overlaps().end());
      })));
  grpc::ClientContext statistics_context;
  SetDeadline(statistics_context);
  v1::GetStatisticsRequest statistics_request;
  statistics_request.set_mission(name);
  v1::GetStatisticsResponse statistics;
  RETURN_IF_ERROR(ToStatus(
      stub->GetStatistics(&statistics_context, statistics_request, &statistics), "GetStatistics"));
  summary.statistics = std::move(*statistics.mutable_mission());
  return summary;
}

}  // namespace corbslam::services
