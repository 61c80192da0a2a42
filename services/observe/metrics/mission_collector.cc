#include "services/observe/metrics/mission_collector.h"

#include <set>
#include <string>

#include "map_store/mission/mission_load.h"
#include "services/observe/metrics/families.h"

namespace corbslam::services {

using map_store::MapStore;
using map_store::MissionLoad;

namespace {

double Number(uint64_t value) { return static_cast<double>(value); }

void AddContents(const MissionLoad& load, Families& families) {
  const MetricLabels mission = {{"mission", load.mission}};
  families.Gauge("corbslam_mission_keyframes", "Keyframes stored.", Number(load.keyframes),
                 mission);
  families.Gauge("corbslam_mission_map_points",
                 "Points of all local maps; a landmark counts once for each robot's point of it.",
                 Number(load.map_points), mission);
  families.Gauge("corbslam_mission_retired_keyframes",
                 "Keyframes of closed local maps that the store let go of.",
                 Number(load.retired_keyframes), mission);
  families.Gauge("corbslam_mission_faded_points",
                 "Points that the store let go of because later sessions did not see them.",
                 Number(load.faded_points), mission);
  families.Gauge("corbslam_mission_joined_local_maps",
                 "Closed local maps that have become parts of others of their robots.",
                 Number(load.joined_local_maps), mission);
  families.Gauge("corbslam_mission_forgotten_local_maps",
                 "Local maps that somebody deleted, with those that were parts of them.",
                 Number(load.forgotten_local_maps), mission);
  families.Gauge("corbslam_mission_local_maps", "Local maps.", Number(load.local_maps), mission);
  families.Gauge("corbslam_mission_islands", "Islands: sets of local maps fused into one frame.",
                 Number(load.islands), mission);
  families.Gauge("corbslam_mission_agents", "Agents that were ever in the mission.",
                 Number(load.agents), mission);
  families.Gauge("corbslam_mission_agents_connected", "Agents with a session now.",
                 Number(load.connected_agents), mission);
  families.Gauge("corbslam_mission_revision", "Changes of the global layer committed so far.",
                 Number(load.revision), mission);
  families.Counter("corbslam_mission_locked_seconds_total",
                   "Time for which changes of the state kept everybody else out.", load.written_s,
                   mission);
  families.Gauge("corbslam_mission_longest_lock_seconds",
                 "Longest time for which one change of the state kept everybody else out.",
                 load.longest_write_s, mission);
}

void AddSpace(const MissionLoad& load, Families& families) {
  const MetricLabels mission = {{"mission", load.mission}};
  families.Gauge("corbslam_mission_memory_bytes", "About how much memory the mission's map takes.",
                 Number(load.memory_bytes), mission);
  families.Gauge("corbslam_mission_disk_bytes", "What the mission takes of the journal's disk.",
                 Number(load.disk_bytes), mission);
}

void AddFusion(const MissionLoad& load, Families& families) {
  const auto stage = [&](const std::string& name, uint64_t value) {
    families.Counter("corbslam_mission_overlaps_total",
                     "Keyframes queried, candidates verified by a worker.", Number(value),
                     {{"mission", load.mission}, {"stage", name}});
  };
  stage("queried", load.overlaps_queried);
  stage("verified", load.overlaps_verified);
  families.Gauge("corbslam_mission_overlaps_accepted",
                 "Overlaps that hold islands together; fewer once one is refused or taken back.",
                 Number(load.overlaps_accepted), {{"mission", load.mission}});
  families.Counter("corbslam_mission_failed_requests_total",
                   "Requests that a fusion worker answered with an error.",
                   Number(load.failed_requests), {{"mission", load.mission}});
  const auto waiting = [&](const std::string& kind, size_t value) {
    families.Gauge("corbslam_fusion_requests_waiting",
                   "Requests to fusion workers that no worker has taken yet.", Number(value),
                   {{"mission", load.mission}, {"kind", kind}});
  };
  waiting("verify", load.waiting.verify);
  waiting("fuse", load.waiting.fuse);
  waiting("adjust", load.waiting.adjust);
}

void AddSleep(const MapStore::Sleep& sleep, Families& families) {
  families.Gauge("corbslam_missions_asleep", "Missions that are on the disk alone.",
                 Number(sleep.asleep));
  families.Counter("corbslam_missions_fallen_asleep_total",
                   "How often a mission that nobody used left memory.",
                   Number(sleep.fallen_asleep));
  families.Counter("corbslam_missions_woken_total", "How often a mission was read again.",
                   Number(sleep.woken));
  families.Counter("corbslam_missions_waking_seconds_total", "What that took all together.",
                   sleep.waking_s);
}

}  // namespace

std::vector<prometheus::MetricFamily> MissionCollector::Collect() const {
  Families families;
  std::set<std::string> missions;
  const std::vector<MissionLoad> loads = store_.ListLoads();
  families.Gauge("corbslam_missions", "Missions in the store.", Number(loads.size()));
  families.Gauge("corbslam_missions_damaged",
                 "Missions whose journal is damaged: they take nothing in.",
                 Number(store_.ListDamaged().size()));
  AddSleep(store_.sleep(), families);
  const MapStore::Memory memory = store_.memory();
  families.Gauge("corbslam_memory_budget_bytes",
                 "Resident memory beyond which nothing is taken in; 0: no limit.",
                 Number(memory.budget_bytes));
  families.Counter("corbslam_memory_refused_total",
                   "Batches and backups' pieces that were refused for want of memory.",
                   Number(memory.refused));
  if (store_.has_worker()) {
    families.Gauge("corbslam_fusion_workers_answer",
                   "0 while no fusion worker takes the store's requests.",
                   store_.worker_outage().has_value() ? 0 : 1);
  }
  for (const MissionLoad& load : loads) {
    AddContents(load, families);
    AddSpace(load, families);
    AddFusion(load, families);
    missions.insert(load.mission);
  }
  ingest_.AddAgents(missions, families);
  families.Gauge("corbslam_service_tasks_waiting",
                 "Calls and messages that no thread of the store has begun with.",
                 Number(service_.waiting_tasks()));
  families.Gauge("corbslam_long_calls",
                 "Backups, restores, sleeps, deletions and the like that are under way, or wait.",
                 Number(service_.long_work()));
  families.Gauge("corbslam_streams_open", "Open streams of agents and viewers.",
                 Number(service_.streams().open_streams()));
  families.Gauge("corbslam_unfinished_batches_bytes",
                 "Bytes held of batches of which not all parts are there.",
                 Number(service_.streams().unfinished_bytes()));
  return families.Take();
}

}  // namespace corbslam::services
