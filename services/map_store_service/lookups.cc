#include <utility>

#include "absl/strings/str_cat.h"
#include "services/convert/features.h"
#include "services/convert/resource_names.h"
#include "services/map_store_service/lookups_to_proto.h"
#include "services/map_store_service/map_store_service.h"
#include "services/map_store_service/paging.h"
#include "services/server/process_usage.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {

using map_store::AgentInfo;
using map_store::KeyframeInfo;
using map_store::LocalMapInfo;
using map_store::MissionInfo;
using map_store::MissionStatistics;
using map_store::OverlapFilter;
using map_store::PageRequest;

absl::Status MapStoreService::GetMission(const v1::GetMissionRequest& request,
                                         v1::Mission* response) {
  ASSIGN_OR_RETURN(const std::string mission, ParseMissionName(request.name()));
  ASSIGN_OR_RETURN(const MissionInfo info, store_.GetMission(mission));
  ToProto(info, response);
  return absl::OkStatus();
}

absl::Status MapStoreService::ListAgents(const v1::ListAgentsRequest& request,
                                         v1::ListAgentsResponse* response) {
  ASSIGN_OR_RETURN(const std::string mission, ParseMissionName(request.parent()));
  ASSIGN_OR_RETURN(const PageRequest page, ReadPage(request));
  ASSIGN_OR_RETURN(const auto found, store_.ListAgents(mission, page));
  for (const auto& item : found.items) ToProto(mission, item, response->add_agents());
  response->set_next_page_token(found.next_page_token);
  return absl::OkStatus();
}

absl::Status MapStoreService::ListLocalMaps(const v1::ListLocalMapsRequest& request,
                                            v1::ListLocalMapsResponse* response) {
  ASSIGN_OR_RETURN(const std::string mission, ParseMissionName(request.parent()));
  ASSIGN_OR_RETURN(const PageRequest page, ReadPage(request));
  ASSIGN_OR_RETURN(const auto found, store_.ListLocalMaps(mission, page));
  for (const auto& item : found.items) ToProto(mission, item, response->add_local_maps());
  response->set_next_page_token(found.next_page_token);
  return absl::OkStatus();
}

absl::Status MapStoreService::GetLocalMap(const v1::GetLocalMapRequest& request,
                                          v1::LocalMap* response) {
  ASSIGN_OR_RETURN(const LocalMapPath path,
                   ParseLocalMapName(request.name(), /*may_be_all=*/false));
  ASSIGN_OR_RETURN(const LocalMapInfo info, store_.GetLocalMap(path.mission, path.local_map));
  ToProto(path.mission, info, response);
  return absl::OkStatus();
}

absl::Status MapStoreService::ListKeyframes(const v1::ListKeyframesRequest& request,
                                            v1::ListKeyframesResponse* response) {
  ASSIGN_OR_RETURN(const LocalMapPath path,
                   ParseLocalMapName(request.parent(), /*may_be_all=*/true));
  ASSIGN_OR_RETURN(const PageRequest page, ReadPage(request));
  ASSIGN_OR_RETURN(const auto found, store_.ListKeyframes(path.mission, path.local_map, page));
  for (const auto& item : found.items) ToProto(path.mission, item, response->add_keyframes());
  response->set_next_page_token(found.next_page_token);
  return absl::OkStatus();
}

absl::Status MapStoreService::GetKeyframe(const v1::GetKeyframeRequest& request,
                                          v1::Keyframe* response) {
  if (!v1::KeyframeView_IsValid(request.view())) {
    return absl::InvalidArgumentError(
        absl::StrCat("view is ", static_cast<int>(request.view()), ", must be 0 to 3"));
  }
  ASSIGN_OR_RETURN(const KeyframePath path, ParseKeyframeName(request.name()));
  if (request.view() == v1::KEYFRAME_VIEW_PICTURE) {
    ASSIGN_OR_RETURN(auto picture, store_.GetPicture(path.mission, path.keyframe));
    if (picture.has_value()) {
      response->set_picture(std::move(picture->jpeg));
      response->set_picture_scale(picture->scale);
    }
  }
  const bool is_full = request.view() == v1::KEYFRAME_VIEW_FULL;
  ASSIGN_OR_RETURN(const KeyframeInfo info,
                   store_.GetKeyframe(path.mission, path.keyframe, /*with_sights=*/is_full));
  ToProto(path.mission, info, response);
  if (is_full) {
    ToProto(*info.payload, response->mutable_payload());
    for (const auto& [keypoint, point] : info.sights) {
      v1::Sight* const sight = response->add_sights();
      sight->set_keypoint(keypoint);
      sight->set_local_map(point.local_map.value);
      sight->set_point(point.index);
    }
  }
  return absl::OkStatus();
}

absl::Status MapStoreService::ListOverlaps(const v1::ListOverlapsRequest& request,
                                           v1::ListOverlapsResponse* response) {
  ASSIGN_OR_RETURN(const std::string mission, ParseMissionName(request.parent()));
  OverlapFilter filter;
  if (request.accepted_only()) filter.accepted = true;
  if (!request.local_map().empty()) {
    ASSIGN_OR_RETURN(const LocalMapPath path,
                     ParseLocalMapName(request.local_map(), /*may_be_all=*/false));
    if (path.mission != mission) {
      return absl::InvalidArgumentError(
          absl::StrCat("local_map ", request.local_map(), " is not of parent ", request.parent()));
    }
    filter.local_map = path.local_map;
  }
  ASSIGN_OR_RETURN(const PageRequest page, ReadPage(request));
  ASSIGN_OR_RETURN(const auto found, store_.ListOverlaps(mission, filter, page));
  for (const auto& item : found.items) ToProto(mission, item, response->add_overlaps());
  response->set_next_page_token(found.next_page_token);
  return absl::OkStatus();
}

absl::Status MapStoreService::GetOverlap(const v1::GetOverlapRequest& request,
                                         v1::Overlap* response) {
  ASSIGN_OR_RETURN(const OverlapPath path, ParseOverlapName(request.name()));
  ASSIGN_OR_RETURN(const map_store::OverlapInfo info,
                   store_.GetOverlap(path.mission, path.overlap));
  ToProto(path.mission, info, response);
  return absl::OkStatus();
}

absl::Status MapStoreService::GetStatistics(const v1::GetStatisticsRequest& request,
                                            v1::GetStatisticsResponse* response) {
  ASSIGN_OR_RETURN(const std::string mission, ParseMissionName(request.mission()));
  ASSIGN_OR_RETURN(const MissionStatistics statistics, store_.GetStatistics(mission));
  v1::MissionStatistics* proto = response->mutable_mission();
  ToProto(mission, statistics, proto);
  ASSIGN_OR_RETURN(const auto local_maps, ReadAllPages<LocalMapInfo>([&](const PageRequest& page) {
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
}

}  // namespace corbslam::services
