#include "services/convert/geometry.h"
#include "services/tool/mission/mission_json.h"
#include "services/tool/mission/mission_summary.h"
#include "services/tool/mission/summary_pairs.h"

namespace corbslam::services {
namespace {

using Json = nlohmann::ordered_json;

Json ToJson(const v1::LastPose& pose) {
  Json json = {{"timestamp_ns", pose.timestamp_ns()},
               {"local_map", pose.local_map()},
               {"island", pose.island()},
               {"in_global_frame", pose.in_global_frame()},
               {"lost_since", pose.lost_since()},
               {"position_in_island", nullptr}};
  const auto camera_from_island = FromProto(pose.camera_from_island());
  if (camera_from_island.ok()) {
    const Eigen::Vector3d centre = CameraCentre(*camera_from_island);
    json["position_in_island"] = {centre.x(), centre.y(), centre.z()};
  }
  return json;
}

Json ToJson(const v1::MissionAgent& agent) {
  Json local_maps = Json::array();
  for (const std::string& name : agent.local_maps()) local_maps.push_back(name);
  Json json = {
      {"name", agent.name()}, {"connected", agent.connected()}, {"local_maps", local_maps}};
  if (agent.localise_only()) json["localise_only"] = true;
  if (agent.has_last_pose()) json["last_pose"] = ToJson(agent.last_pose());
  return json;
}

Json ToJson(const v1::LocalMap& local_map, const std::string& short_name) {
  return {{"name", local_map.name()},
          {"short_name", short_name},
          {"agent", local_map.agent()},
          {"island", local_map.island()},
          {"in_global_frame", local_map.in_global_frame()},
          {"closed", local_map.closed()},
          {"keyframes", local_map.keyframes()},
          {"map_points", local_map.map_points()},
          {"tracked_frames", local_map.tracked_frames()},
          {"lost_frames", local_map.lost_frames()}};
}

Json ToJson(const std::pair<std::string, std::string>& names, const PairOverlaps& pair) {
  Json verdicts = Json::object();
  for (const auto& [verdict, count] : pair.verdicts) {
    verdicts[v1::OverlapVerdict_Name(verdict)] = count;
  }
  return {{"local_maps", {names.first, names.second}},
          {"same_island", pair.same_island},
          {"accepted", pair.accepted},
          {"refused", pair.refused},
          {"waiting", pair.waiting},
          {"failed", pair.failed},
          {"verdicts", verdicts}};
}

}  // namespace

nlohmann::ordered_json ToJson(const v1::Mission& mission) {
  return {{"name", mission.name()},
          {"revision", mission.revision()},
          {"agents", mission.agents()},
          {"local_maps", mission.local_maps()},
          {"islands", mission.islands()},
          {"keyframes", mission.keyframes()},
          {"map_points", mission.map_points()},
          {"fusion_idle", mission.fusion_idle()},
          {"waiting_queries", mission.waiting_queries()},
          {"lacks_fusion_worker", mission.lacks_fusion_worker()},
          {"worker_away_since_ns", mission.worker_away_since_ns()},
          {"worker_error", mission.worker_error()},
          {"memory_bytes", mission.memory_bytes()},
          {"disk_bytes", mission.disk_bytes()},
          {"damage", mission.damage()},
          {"asleep", mission.asleep()},
          {"last_used_ns", mission.last_used_ns()}};
}

nlohmann::ordered_json ToJson(const MissionSummary& summary) {
  const std::map<std::string, std::string> names = ShortNames(summary);
  Json json = {{"mission", ToJson(summary.mission)},
               {"agents", Json::array()},
               {"local_maps", Json::array()},
               {"overlaps", summary.overlaps.size()},
               {"pairs", Json::array()}};
  for (const v1::MissionAgent& agent : summary.agents) json["agents"].push_back(ToJson(agent));
  for (const v1::LocalMap& local_map : summary.local_maps) {
    json["local_maps"].push_back(ToJson(local_map, names.at(local_map.name())));
  }
  for (const auto& [pair_names, pair] : CountPairs(summary)) {
    json["pairs"].push_back(ToJson(pair_names, pair));
  }
  return json;
}

}  // namespace corbslam::services
