#include "services/map_store_service/lookups_to_proto.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>

#include "services/convert/agent_report.h"
#include "services/convert/geometry.h"
#include "services/convert/overlap.h"
#include "services/convert/resource_names.h"
#include "services/map_store_service/profile_convert.h"

namespace corbslam::services {

using map_store::AgentInfo;
using map_store::GlobalAdjustmentStatistics;
using map_store::IslandId;
using map_store::KeyframeInfo;
using map_store::LocalMapInfo;
using map_store::MissionInfo;
using map_store::MissionStatistics;
using map_store::OverlapInfo;
using map_store::TransferStatistics;
using map_store::UncomparedPair;

namespace {

std::string NameOrEmpty(absl::string_view mission, LocalMapId id) {
  return id.IsValid() ? LocalMapName(mission, id) : std::string();
}

void ToProto(const TransferStatistics& transfer, v1::TransferCount* proto) {
  proto->set_count(transfer.count);
  proto->set_bytes(transfer.bytes);
  proto->set_ms(transfer.ms);
}

// Returns the standard deviation along the least certain direction.
double LargestSigma(const Eigen::Matrix3d& covariance) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(covariance, Eigen::EigenvaluesOnly);
  return std::sqrt(std::max(solver.eigenvalues()[2], 0.0));
}

uint32_t Count(size_t value) { return static_cast<uint32_t>(value); }

}  // namespace

void ToProto(const MissionInfo& info, v1::Mission* proto) {
  proto->set_name(MissionName(info.name));
  proto->set_revision(info.revision);
  proto->set_agents(Count(info.agents));
  proto->set_local_maps(Count(info.local_maps));
  proto->set_islands(Count(info.islands));
  proto->set_keyframes(info.keyframes);
  proto->set_map_points(info.map_points);
  proto->set_fusion_idle(info.fusion_idle);
  proto->set_waiting_queries(info.waiting_queries);
  proto->set_lacks_fusion_worker(!info.has_worker);
  proto->set_memory_bytes(info.memory_bytes);
  proto->set_disk_bytes(info.disk_bytes);
  proto->set_damage(info.damage);
  ToProto(info.profile, proto);
  proto->set_asleep(info.asleep);
  proto->set_uid(info.uid);
  proto->set_connected_agents(Count(info.connected_agents));
  if (!info.worker_outage.has_value()) return;
  proto->set_worker_away_since_ns(absl::ToUnixNanos(info.worker_outage->begin));
  proto->set_worker_error(info.worker_outage->cause);
}

void ToProto(absl::string_view mission, const map_store::LastPose& pose, v1::LastPose* proto) {
  proto->set_timestamp_ns(pose.timestamp_ns);
  proto->set_local_map(NameOrEmpty(mission, pose.local_map));
  proto->set_island(LocalMapName(mission, pose.island));
  proto->set_in_global_frame(pose.in_reference_island);
  ToProto(pose.camera_from_island, proto->mutable_camera_from_island());
  proto->set_lost_since(pose.lost_since);
}

void ToProto(absl::string_view mission, const AgentInfo& info, v1::MissionAgent* proto) {
  proto->set_name(AgentName(mission, info.name));
  proto->set_connected(info.connected);
  for (const LocalMapId id : info.local_maps) proto->add_local_maps(LocalMapName(mission, id));
  proto->set_up_to_date(info.up_to_date);
  proto->set_shared_updates(info.shared_updates);
  proto->set_localise_only(info.localise_only);
  if (info.last_pose.has_value()) ToProto(mission, *info.last_pose, proto->mutable_last_pose());
  if (info.report.has_value()) {
    ToProto(*info.report, proto->mutable_report());
    proto->set_report_age_s(absl::ToDoubleSeconds(info.report_age));
  }
  proto->set_left_on_purpose(info.left_on_purpose);
}

void ToProto(absl::string_view mission, const LocalMapInfo& info, v1::LocalMap* proto) {
  proto->set_name(LocalMapName(mission, info.id));
  proto->set_agent(AgentName(mission, info.agent));
  proto->set_number(Count(info.number));
  proto->set_island(NameOrEmpty(mission, info.island));
  proto->set_in_global_frame(info.in_reference_island);
  proto->set_closed(info.closed);
  proto->set_last_batch(info.last_batch);
  proto->set_keyframes(info.keyframes);
  proto->set_settled_keyframes(info.settled_keyframes);
  proto->set_placed_keyframes(info.placed_keyframes);
  proto->set_map_points(info.map_points);
  proto->set_tracked_frames(info.tracked_frames);
  proto->set_lost_frames(info.lost_frames);
  proto->set_parked_references(info.parked_references);
  proto->set_retired_keyframes(info.retired_keyframes);
  for (const LocalMapId& part : info.joined) {
    proto->add_joined_local_maps(LocalMapName(mission, part));
  }
  for (const uint64_t number : info.joined_numbers) proto->add_joined_numbers(Count(number));
  proto->set_faded_map_points(info.faded_points);
  proto->set_without_metres(!info.in_metres);
  proto->set_island_without_metres(!info.island_in_metres);
}

void ToProto(absl::string_view mission, const KeyframeInfo& info, v1::Keyframe* proto) {
  proto->set_name(KeyframeName(mission, info.id));
  proto->set_agent(AgentName(mission, info.agent));
  proto->set_timestamp_ns(info.payload->timestamp_ns);
  ToProto(info.camera_from_local, proto->mutable_camera_from_local());
  proto->set_island(NameOrEmpty(mission, info.island));
  ToProto(info.camera_from_island, proto->mutable_camera_from_island());
  proto->set_placed(info.placed);
  proto->set_settled(info.settled);
  proto->set_revision(info.revision);
  if (info.parent.IsValid()) proto->set_parent(KeyframeName(mission, info.parent));
  proto->set_keypoints(Count(info.keypoints));
  proto->set_observed_points(Count(info.observed_points));
}

void ToProto(absl::string_view mission, const OverlapInfo& info, v1::Overlap* proto) {
  proto->set_query(KeyframeName(mission, info.overlap.query));
  proto->set_candidate(KeyframeName(mission, info.overlap.candidate));
  if (info.overlap.IsAccepted() || !info.overlap.inliers.empty()) {
    ToProto(info.overlap.candidate_from_query, proto->mutable_candidate_from_query());
  }
  const Matrix7d& covariance = info.overlap.covariance;
  proto->set_translation_sigma(LargestSigma(covariance.topLeftCorner<3, 3>()));
  proto->set_rotation_sigma_rad(LargestSigma(covariance.block<3, 3>(3, 3)));
  proto->set_log_scale_sigma(std::sqrt(std::max(covariance(6, 6), 0.0)));
  proto->set_inliers(Count(info.overlap.inliers.size()));
  ToProto(info.overlap.evidence, proto->mutable_evidence());
  proto->set_verdict(ToProto(info.overlap.verdict));
  proto->set_revision(info.revision);
  proto->set_fused(info.fused);
  proto->set_number(info.id);
  proto->set_name(OverlapName(mission, info.id));
  proto->set_note(info.note);
  for (const auto& [query, candidate] : info.matches) {
    v1::OverlapMatch* const match = proto->add_matches();
    match->set_query_x_px(static_cast<float>(query.x()));
    match->set_query_y_px(static_cast<float>(query.y()));
    match->set_candidate_x_px(static_cast<float>(candidate.x()));
    match->set_candidate_y_px(static_cast<float>(candidate.y()));
  }
}

void ToProto(absl::string_view mission, const MissionStatistics& statistics,
             v1::MissionStatistics* proto) {
  proto->set_mission(MissionName(mission));
  proto->set_revision(statistics.revision);
  proto->set_keyframes(statistics.keyframes);
  proto->set_map_points(statistics.map_points);
  proto->set_overlaps_queried(statistics.overlaps_queried);
  proto->set_overlaps_verified(statistics.overlaps_verified);
  proto->set_overlaps_accepted(statistics.overlaps_accepted);
  for (const double ms : statistics.merge_ms) proto->add_merge_ms(ms);
  for (const GlobalAdjustmentStatistics& adjustment : statistics.global_adjustments) {
    v1::AdjustmentRecord* record = proto->add_adjustments();
    record->set_keyframes(static_cast<uint32_t>(adjustment.keyframes));
    record->set_map_points(static_cast<uint32_t>(adjustment.map_points));
    record->set_iterations(static_cast<uint32_t>(adjustment.iterations));
    record->set_ms(adjustment.ms);
  }
  v1::TransferStatistics* transfer = proto->mutable_transfer();
  ToProto(statistics.full_keyframes, transfer->mutable_full_keyframes());
  ToProto(statistics.full_map_points, transfer->mutable_full_map_points());
  ToProto(statistics.light_keyframes, transfer->mutable_light_keyframes());
  ToProto(statistics.light_map_points, transfer->mutable_light_map_points());
  proto->set_failed_requests(statistics.failed_requests);
  for (const UncomparedPair& pair : statistics.uncompared) {
    v1::UncomparedPair* added = proto->add_uncompared();
    added->set_query(LocalMapName(mission, pair.query));
    added->set_against(LocalMapName(mission, pair.against));
    added->set_waiting(pair.waiting);
    added->set_failed(pair.failed);
  }
}

void AddIslands(absl::string_view mission, const std::vector<LocalMapInfo>& local_maps,
                v1::MissionStatistics* proto) {
  // The reference island sorts first.
  std::map<std::pair<bool, IslandId>, std::vector<const LocalMapInfo*>> islands;
  for (const LocalMapInfo& info : local_maps) {
    islands[{!info.in_reference_island, info.island}].push_back(&info);
  }
  for (auto& [key, members] : islands) {
    v1::IslandStatistics* island = proto->add_islands();
    island->set_in_global_frame(!key.first);
    std::set<std::string> agents;
    uint64_t keyframes = 0;
    // The local map that names the island comes first.
    const auto names_it = [id = key.second](const LocalMapInfo* info) { return info->id == id; };
    std::stable_partition(members.begin(), members.end(), names_it);
    for (const LocalMapInfo* info : members) {
      island->add_local_maps(LocalMapName(mission, info->id));
      agents.insert(AgentName(mission, info->agent));
      keyframes += info->keyframes;
    }
    for (const std::string& agent : agents) island->add_agents(agent);
    island->set_keyframes(keyframes);
  }
}

}  // namespace corbslam::services
