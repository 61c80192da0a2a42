#include "map_store/mission/mission.h"

#include "map_store/view/answers.h"
#include "map_store/view/memory_estimate.h"

namespace corbslam::map_store {
namespace {

MissionLoad MeasureLoad(const MissionState& state) {
  MissionLoad load;
  load.revision = state.global.revision;
  load.agents = state.agents.size();
  for (const auto& [name, agent] : state.agents) load.connected_agents += agent.session != 0;
  load.local_maps = state.local_maps.size();
  load.islands = state.global.islands.size();
  for (const auto& [id, local_map] : state.local_maps) {
    load.keyframes += local_map.map.keyframes().size();
    load.map_points += local_map.map.points().size();
  }
  load.memory_bytes = EstimateMemory(state);
  load.overlaps_queried = state.statistics.overlaps_queried;
  load.overlaps_verified = state.statistics.overlaps_verified;
  load.overlaps_accepted = state.statistics.overlaps_accepted;
  load.failed_requests = state.statistics.failed_requests;
  return load;
}

}  // namespace

Mission::Mission(std::string name, MissionEnvironment environment)
    : strand_(std::move(name), std::move(environment)),
      events_(strand_.environment().clock, strand_.name()),
      sessions_(strand_, events_),
      batches_(strand_, sessions_.listeners(), events_),
      fusion_(strand_, events_, [this] { sessions_.listeners().CallAllBut(0); }),
      snapshots_(strand_) {}

MissionInfo Mission::Info() const {
  MissionInfo info = WithState(DescribeMission);
  info.fusion_idle = fusion_.IsIdle();
  return info;
}

MissionLoad Mission::Load() const {
  MissionLoad load = WithState(&MeasureLoad);
  load.mission = strand_.name();
  load.disk_bytes = strand_.environment().journal->DiskBytes(strand_.name());
  load.waiting = fusion_.CountWaiting();
  const MissionStrand::WriteTimes writes = strand_.write_times();
  load.written_s = absl::ToDoubleSeconds(writes.total);
  load.longest_write_s = absl::ToDoubleSeconds(writes.longest);
  return load;
}

bool Mission::IsVacant() const {
  return strand_.appended() == 0 && !sessions_.listeners().has_of_map() &&
         !events_.listeners().has_of_map() &&
         WithState([](const MissionState& state) { return state.local_maps.empty(); });
}

void Mission::Delete() {
  {
    absl::MutexLock turn(&strand_.turn());
    strand_.MarkDeleted();
    fusion_.Stop();
  }
  // A snapshot that has begun must not be written after the deletion.
  snapshots_.WaitForEnd();
  CallListeners();
}

void Mission::CallListeners() {
  listeners().CallAllBut(0);
  events_.listeners().CallAllBut(0);
}

}  // namespace corbslam::map_store
