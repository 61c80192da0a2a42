#include "services/tool/run/record_mission.h"

#include <cstddef>
#include <cstdint>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "corbslam/v1/viewer.pb.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {
namespace {

// In the page each byte takes four thirds of one.
constexpr size_t kMostBytes = 6'000'000;
constexpr uint32_t kMoments = 60;

absl::StatusOr<std::vector<std::string>> ReadPast(StoreReader& store, uint32_t moments,
                                                  bool with_points) {
  std::vector<std::string> past;
  size_t bytes = 0;
  const auto take = [&](const v1::WatchMapResponse& message) {
    past.push_back(message.SerializeAsString());
    bytes += past.back().size();
    if (bytes <= kMostBytes) return absl::OkStatus();
    return absl::ResourceExhaustedError(
        absl::StrCat("the mission's past is longer than ", kMostBytes, " bytes"));
  };
  RETURN_IF_ERROR(store.ReadPast(moments, with_points, take));
  return past;
}

absl::StatusOr<std::vector<std::string>> ReadShortPast(StoreReader& store) {
  absl::StatusOr<std::vector<std::string>> past = ReadPast(store, kMoments, /*with_points=*/true);
  if (absl::IsResourceExhausted(past.status())) past = ReadPast(store, 2, /*with_points=*/true);
  if (absl::IsResourceExhausted(past.status())) past = ReadPast(store, kMoments, false);
  return past;
}

// Returns what a viewer would tell of the mission now.
absl::StatusOr<v1::MissionPulse> ReadPulse(StoreReader& store) {
  v1::MissionPulse pulse;
  pulse.set_time_ns(absl::GetCurrentTimeNanos());
  pulse.set_store_answers(true);
  ASSIGN_OR_RETURN(const v1::GetStatisticsResponse statistics, store.Statistics());
  *pulse.mutable_statistics() = statistics.mission();
  ASSIGN_OR_RETURN(const auto agents, store.ListAgents());
  for (const auto& [name, agent] : agents) *pulse.add_agents() = agent;
  ASSIGN_OR_RETURN(const std::vector<v1::LocalMap> local_maps, store.ListLocalMaps());
  for (const v1::LocalMap& local_map : local_maps) *pulse.add_local_maps() = local_map;
  return pulse;
}

}  // namespace

absl::StatusOr<MissionPast> RecordMission(StoreReader& store, const std::string& mission) {
  MissionPast recorded;
  recorded.mission = mission;
  ASSIGN_OR_RETURN(recorded.past, ReadShortPast(store));
  ASSIGN_OR_RETURN(const v1::MissionPulse pulse, ReadPulse(store));
  recorded.pulse = pulse.SerializeAsString();
  ASSIGN_OR_RETURN(const std::vector<v1::Overlap> overlaps, store.ListOverlaps());
  for (const v1::Overlap& overlap : overlaps) {
    recorded.overlaps.push_back(overlap.SerializeAsString());
  }
  return recorded;
}

}  // namespace corbslam::services
