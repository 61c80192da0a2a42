#include <string>
#include <utility>

#include "services/client/store/local_map_names.h"
#include "services/convert/geometry.h"
#include "services/tool/mission/mission_json.h"
#include "services/tool/mission/mission_summary.h"
#include "services/tool/mission/summary_pairs.h"
#include "slam/util/ids.h"

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

Json ToJson(const v1::AgentReport& report) {
  Json contradictions = Json::array();
  for (const v1::MapContradiction& found : report.contradictions()) {
    Json said = {{"local_map", ToString(LocalMapId{found.local_map()})},
                 {"scale", found.scale()},
                 {"scale_sigma", found.scale_sigma()}};
    if (found.has_bend()) {
      said["bend"] = {{"way_m", found.bend().way_m()},
                      {"shift_m", found.bend().shift_m()},
                      {"turn_rad", found.bend().turn_rad()}};
    }
    contradictions.push_back(std::move(said));
  }
  return {{"activity", v1::AgentActivity_Name(report.activity())},
          {"frames", report.frames()},
          {"tracked", report.tracked()},
          {"lost", report.lost()},
          {"dropped", report.dropped()},
          {"newest_timestamp_ns", report.newest_timestamp_ns()},
          {"newest_frame_age_s", report.newest_frame_age_s()},
          {"contradictions", std::move(contradictions)}};
}

Json ToJson(const v1::MissionAgent& agent) {
  Json local_maps = Json::array();
  for (const std::string& name : agent.local_maps()) local_maps.push_back(name);
  Json json = {
      {"name", agent.name()}, {"connected", agent.connected()}, {"local_maps", local_maps}};
  if (agent.localise_only()) json["localise_only"] = true;
  if (agent.has_last_pose()) json["last_pose"] = ToJson(agent.last_pose());
  if (agent.has_report()) {
    json["report"] = ToJson(agent.report());
    json["report_age_s"] = agent.report_age_s();
  }
  if (agent.left_on_purpose()) json["left_on_purpose"] = true;
  return json;
}

// Returns the short names of those that became parts of it.
Json PartNames(const v1::LocalMap& local_map, const LocalMapNames& names) {
  Json parts = Json::array();
  for (const std::string& part : local_map.joined_local_maps()) parts.push_back(names.at(part));
  return parts;
}

Json ToJson(const v1::LocalMap& local_map, const LocalMapNames& names) {
  return {{"name", local_map.name()},
          {"short_name", names.at(local_map.name())},
          {"agent", local_map.agent()},
          {"island", local_map.island()},
          {"in_global_frame", local_map.in_global_frame()},
          {"without_metres", local_map.without_metres()},
          {"island_without_metres", local_map.island_without_metres()},
          {"closed", local_map.closed()},
          {"keyframes", local_map.keyframes()},
          {"map_points", local_map.map_points()},
          {"retired_keyframes", local_map.retired_keyframes()},
          {"faded_map_points", local_map.faded_map_points()},
          {"joined_local_maps", local_map.joined_local_maps_size()},
          {"parts", PartNames(local_map, names)},
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

Json ToJson(const v1::MissionLimits& limits) {
  return {{"keyframes", limits.keyframes()},
          {"memory_bytes", limits.memory_bytes()},
          {"disk_bytes", limits.disk_bytes()},
          {"uplink_bytes_per_second", limits.uplink_bytes_per_second()}};
}

// Adds what is set of the mission. A protobuf map has no order, so that a map is made of it.
void AddSettings(const v1::Mission& mission, Json& json) {
  json["description"] = mission.description();
  json["labels"] = Json::object();
  for (const auto& [key, value] :
       std::map<std::string, std::string>(mission.labels().begin(), mission.labels().end())) {
    json["labels"][key] = value;
  }
  json["limits"] = ToJson(mission.limits());
  json["agent_limits"] = Json::object();
  for (const auto& [agent, limits] : std::map<std::string, v1::MissionLimits>(
           mission.agent_limits().begin(), mission.agent_limits().end())) {
    json["agent_limits"][agent] = ToJson(limits);
  }
  json["retention_s"] = mission.retention_s();
  json["origin"] = nullptr;
  if (mission.has_origin()) {
    json["origin"] = {{"latitude_deg", mission.origin().latitude_deg()},
                      {"longitude_deg", mission.origin().longitude_deg()},
                      {"altitude_m", mission.origin().altitude_m()},
                      {"heading_deg", mission.origin().heading_deg()}};
  }
  json["created_ns"] = mission.created_ns();
  json["last_used_ns"] = mission.last_used_ns();
}

}  // namespace

nlohmann::ordered_json ToJson(const v1::Mission& mission) {
  Json json = {{"name", mission.name()},
               {"uid", mission.uid()},
               {"revision", mission.revision()},
               {"agents", mission.agents()},
               {"connected_agents", mission.connected_agents()},
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
               {"asleep", mission.asleep()}};
  AddSettings(mission, json);
  return json;
}

nlohmann::ordered_json ToJson(const MissionSummary& summary) {
  const LocalMapNames names = ShortNames(summary.local_maps);
  Json json = {{"mission", ToJson(summary.mission)},
               {"agents", Json::array()},
               {"local_maps", Json::array()},
               {"overlaps", summary.overlaps.size()},
               {"pairs", Json::array()}};
  for (const v1::MissionAgent& agent : summary.agents) json["agents"].push_back(ToJson(agent));
  for (const v1::LocalMap& local_map : summary.local_maps) {
    json["local_maps"].push_back(ToJson(local_map, names));
  }
  for (const auto& [pair_names, pair] : CountPairs(summary)) {
    json["pairs"].push_back(ToJson(pair_names, pair));
  }
  return json;
}

}  // namespace corbslam::services
